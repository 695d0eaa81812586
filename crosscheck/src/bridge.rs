//! The pipe to MuJoCo: requests out, answers in.
//!
//! In: a Python with MuJoCo. Out: a [`Bridge`] that loads models and answers about them. The other end is
//! `driver.py`, which says the framing. Numbers here are in MuJoCo's layout; [`formats::mujoco_layout`] converts.

use std::io::{BufRead, BufReader, BufWriter, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use formats::mujoco_layout::JointThere;
use motion::{Joint, Skeleton, Vec3};
use serde::Deserialize;
use serde_json::{Value, json};

/// Why MuJoCo does not answer.
#[derive(Debug, thiserror::Error)]
pub enum BridgeError {
    /// It could not be started or went away.
    #[error("MuJoCo's process {0}")]
    Gone(String),
    /// It refused a request.
    #[error("MuJoCo refuses: {0}")]
    Refused(String),
    /// It has other joints than we.
    #[error("the two models do not have the same joints: {0}")]
    Joints(String),
    /// It has other bodies than we.
    #[error("the two models do not have the same bodies: {0}")]
    Bodies(String),
    /// It answered something else than asked.
    #[error("MuJoCo answered {found} numbers, {wanted} were expected")]
    Length {
        /// Numbers found.
        found: usize,
        /// Numbers expected.
        wanted: usize,
    },
}

/// A joint of a loaded model.
#[derive(Clone, Debug, Deserialize)]
pub struct JointInfo {
    /// Name.
    pub name: String,
    /// `free`, `ball`, `slide` or `hinge`.
    pub kind: String,
    /// Start in `qpos`.
    pub q: usize,
    /// Start in `qvel`.
    pub v: usize,
    /// Name of its body.
    pub body: String,
}

/// A body of a loaded model.
#[derive(Clone, Debug, Deserialize)]
pub struct BodyInfo {
    /// Name.
    pub name: String,
    /// Mass, kg.
    pub mass: f64,
}

/// A loaded model.
#[derive(Clone, Debug, Deserialize)]
pub struct ModelInfo {
    /// Length of `qpos`.
    pub nq: usize,
    /// Length of `qvel`.
    pub nv: usize,
    /// Joints in order.
    pub joints: Vec<JointInfo>,
    /// Bodies in order, the world first.
    pub bodies: Vec<BodyInfo>,
    /// Gravity in the file's axes, m/s².
    pub gravity: [f64; 3],
    /// MuJoCo's version.
    pub version: String,
    /// Reference pose, `nq`.
    #[serde(skip)]
    pub qpos0: Vec<f64>,
    /// Centre of mass of each body in the reference pose, the file's world, m.
    #[serde(skip)]
    pub coms: Vec<Vec3>,
    /// Position of each joint in the reference pose, m.
    #[serde(skip)]
    pub anchors: Vec<Vec3>,
    /// Axis of each hinge or slide in the reference pose.
    #[serde(skip)]
    pub axes: Vec<Vec3>,
}

impl ModelInfo {
    /// Where the joints of `links`, given in MuJoCo's order, are in its vectors.
    ///
    /// # Errors
    /// [`BridgeError::Joints`] if the joints differ in number or kind.
    pub fn places(&self, skeleton: &Skeleton, links: &[usize]) -> Result<Vec<JointThere>, BridgeError> {
        if links.len() != self.joints.len() {
            let (ours, theirs) = (links.len(), self.joints.len());
            return Err(BridgeError::Joints(format!("ours has {ours} moving joints, MuJoCo's {theirs}")));
        }
        let place = |(&link, there): (&usize, &JointInfo)| {
            let kind = match skeleton.links()[link].joint {
                Joint::Free => "free",
                Joint::Spherical => "ball",
                Joint::Revolute(_) => "hinge",
                Joint::Prismatic(_) => "slide",
                Joint::Fixed => "weld",
            };
            if kind == there.kind {
                Ok(JointThere { link, q: there.q, v: there.v })
            } else {
                let (name, theirs) = (&there.name, &there.kind);
                Err(BridgeError::Joints(format!("`{name}` is a {theirs} in MuJoCo and a {kind} in ours")))
            }
        };
        links.iter().zip(&self.joints).map(place).collect()
    }
}

impl ModelInfo {
    /// Names the bodies as we do: those of a file in its order, the base first. Bodies without a name have ours then.
    ///
    /// # Errors
    /// [`BridgeError::Bodies`] if they differ in number, or in a name that the file has.
    pub fn name_bodies(&mut self, names: &[&str]) -> Result<(), BridgeError> {
        let (ours, theirs) = (names.len(), self.bodies.len());
        if ours != theirs {
            return Err(BridgeError::Bodies(format!("ours has {ours}, MuJoCo's {theirs}")));
        }
        for (body, name) in self.bodies.iter_mut().zip(names).skip(1) {
            if !body.name.is_empty() && body.name != *name {
                return Err(BridgeError::Bodies(format!("`{name}` is `{}` in MuJoCo", body.name)));
            }
            (*name).clone_into(&mut body.name);
        }
        Ok(())
    }
}

/// A running MuJoCo. See the module header.
pub struct Bridge {
    child: Child,
    /// Reads what the process says aside, so that it never waits for a reader; ends with it.
    said: Option<JoinHandle<String>>,
    to: BufWriter<ChildStdin>,
    from: BufReader<ChildStdout>,
    bytes: Vec<u8>,
    /// Whether the process ended.
    gone: bool,
}

/// A running MuJoCo that several uses take turns with.
pub type Shared = Arc<Mutex<Bridge>>;

/// The MuJoCo of a shared bridge, for one request or several.
pub fn lock(bridge: &Shared) -> MutexGuard<'_, Bridge> {
    bridge.lock().unwrap_or_else(PoisonError::into_inner)
}

const DRIVER: &str = include_str!("driver.py");

impl Bridge {
    /// Starts MuJoCo in `python`.
    ///
    /// # Errors
    /// [`BridgeError::Gone`].
    pub fn start(python: &Path) -> Result<Self, BridgeError> {
        let gone = |e: std::io::Error| BridgeError::Gone(format!("cannot be started: {e}"));
        let mut child = Command::new(python)
            .args(["-c", DRIVER])
            // MuJoCo leaves its log where it runs
            .current_dir(std::env::temp_dir())
            .env("PYTHONDONTWRITEBYTECODE", "1")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(gone)?;
        let to = BufWriter::new(child.stdin.take().expect("piped"));
        let from = BufReader::new(child.stdout.take().expect("piped"));
        let stderr = child.stderr.take().expect("piped");
        let said = Some(std::thread::spawn(move || last_line(stderr)));
        let mut bridge = Self { child, said, to, from, bytes: Vec::new(), gone: false };
        bridge.receive()?;
        Ok(bridge)
    }

    /// The same, to be shared.
    pub fn shared(self) -> Shared {
        Arc::new(Mutex::new(self))
    }

    /// Whether the process ended, so that it answers no more.
    pub fn is_gone(&self) -> bool {
        self.gone
    }

    /// Loads a model from a file or from text; contacts, limits, equalities, friction losses, springs,
    /// dampers and actuators named in `disable` are off. Armature is left out with `no_armature`.
    ///
    /// # Errors
    /// [`BridgeError::Refused`] with MuJoCo's words.
    pub fn load(
        &mut self,
        model: &Source<'_>,
        disable: &[&str],
        no_armature: bool,
    ) -> Result<ModelInfo, BridgeError> {
        let mut request = json!({"op": "load", "disable": disable, "no_armature": no_armature});
        match model {
            Source::Text(text) => request["xml"] = json!(text),
            Source::File(path) => request["path"] = json!(path.to_string_lossy()),
        }
        let (head, numbers) = self.call(&request, &[])?;
        let mut info: ModelInfo = serde_json::from_value(head)
            .map_err(|e| BridgeError::Gone(format!("its answer cannot be read: {e}")))?;
        let (nq, nb, nj) = (info.nq, info.bodies.len(), info.joints.len());
        expect(&numbers, nq + 3 * nb + 6 * nj)?;
        let triples = |x: &[f64]| x.chunks_exact(3).map(|c| Vec3::new(c[0], c[1], c[2])).collect();
        let (first, rest) = numbers.split_at(nq);
        let (coms, rest) = rest.split_at(3 * nb);
        let (anchors, axes) = rest.split_at(3 * nj);
        info.qpos0 = first.to_vec();
        info.coms = triples(coms);
        info.anchors = triples(anchors);
        info.axes = triples(axes);
        Ok(info)
    }

    /// Sends a request and waits for the answer.
    ///
    /// # Errors
    /// [`BridgeError`].
    pub fn call(&mut self, head: &Value, numbers: &[f64]) -> Result<(Value, Vec<f64>), BridgeError> {
        let text = head.to_string();
        let sent = (|| {
            self.to.write_all(&(text.len() as u32).to_le_bytes())?;
            self.to.write_all(text.as_bytes())?;
            self.to.write_all(&(numbers.len() as u32).to_le_bytes())?;
            for x in numbers {
                self.to.write_all(&x.to_le_bytes())?;
            }
            self.to.flush()
        })();
        match sent {
            Ok(()) => self.receive(),
            Err(_) => Err(self.gone()),
        }
    }

    fn receive(&mut self) -> Result<(Value, Vec<f64>), BridgeError> {
        let mut read = || -> std::io::Result<(Value, Vec<f64>)> {
            let mut size = [0; 4];
            self.from.read_exact(&mut size)?;
            self.bytes.resize(u32::from_le_bytes(size) as usize, 0);
            self.from.read_exact(&mut self.bytes)?;
            let head = serde_json::from_slice(&self.bytes)?;
            self.from.read_exact(&mut size)?;
            self.bytes.resize(8 * u32::from_le_bytes(size) as usize, 0);
            self.from.read_exact(&mut self.bytes)?;
            let number = |c: &[u8]| f64::from_le_bytes(c.try_into().expect("eight bytes"));
            Ok((head, self.bytes.chunks_exact(8).map(number).collect()))
        };
        match read() {
            Ok((head, numbers)) => match head.get("error").and_then(Value::as_str) {
                Some(text) => Err(BridgeError::Refused(text.into())),
                None => Ok((head, numbers)),
            },
            Err(_) => Err(self.gone()),
        }
    }

    /// What the process said before it went away.
    fn gone(&mut self) -> BridgeError {
        self.gone = true;
        let _ = self.child.kill();
        let last = self.said.take().and_then(|said| said.join().ok()).filter(|line| !line.is_empty());
        BridgeError::Gone(format!("went away: {}", last.as_deref().unwrap_or("without a word")))
    }
}

/// The last line of a stream that is not blank.
fn last_line(stream: impl Read) -> String {
    let mut last = String::new();
    for line in BufReader::new(stream).split(b'\n').map_while(Result::ok) {
        let line = String::from_utf8_lossy(&line);
        if !line.trim().is_empty() {
            last = line.trim_end().to_owned();
        }
    }
    last
}

impl Drop for Bridge {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Where MuJoCo gets a model from.
#[derive(Clone, Copy, Debug)]
pub enum Source<'a> {
    /// MJCF text.
    Text(&'a str),
    /// An MJCF or URDF file.
    File(&'a Path),
}

/// Checks the length of an answer.
///
/// # Errors
/// [`BridgeError::Length`].
pub fn expect(numbers: &[f64], wanted: usize) -> Result<(), BridgeError> {
    if numbers.len() == wanted { Ok(()) } else { Err(BridgeError::Length { found: numbers.len(), wanted }) }
}
