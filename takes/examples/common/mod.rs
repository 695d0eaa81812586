//! How the examples that perform clips free are asked: one set of words for all of them.

use std::path::PathBuf;
use std::str::FromStr;

use motion::names::Word;
use sim::foresight::{Foreseen, Settings};
use takes::overrides::{RootChoice, SoleName, ToesName};
use takes::{Ask, LookAhead, Overrides};

/// What went wrong, for a person.
pub type Failed = Box<dyn std::error::Error>;

/// Clips of `shared/mocap/bvh` that stand from beginning to end.
const STANDS: [&str; 8] = ["02_05", "05_06", "104_41", "127_01", "135_04", "135_08", "14_24", "14_37"];

/// What is performed, and how.
pub struct Options {
    /// Clips and scenes; of folders their clips that step.
    pub files: Vec<PathBuf>,
    /// One run for each.
    pub seeds: Vec<u64>,
    /// How all look ahead, but for the seed.
    pub settings: Settings,
    /// Without foresight.
    blind: bool,
    /// What the words say beside.
    ask: Ask,
}

/// The words after a command, one by one.
pub struct Words(std::iter::Skip<std::env::Args>);

impl Words {
    /// The value of `word`.
    pub fn value<T: FromStr<Err: std::fmt::Display>>(&mut self, word: &str) -> Result<T, Failed> {
        let text = self.0.next().ok_or(format!("{word} needs a value"))?;
        text.parse().map_err(|e| format!("{word} {text}: {e}").into())
    }

    /// The values of `word`, with commas between them.
    pub fn values<T: FromStr<Err: std::fmt::Display>>(&mut self, word: &str) -> Result<Vec<T>, Failed> {
        let text: String = self.value(word)?;
        let one = |part: &str| part.parse().map_err(|e| format!("{word} {part}: {e}").into());
        text.split(',').map(one).collect()
    }
}

impl Options {
    /// Reads the command line: root free, tension 2, `substeps` (`None`: those of the engine), seed 1 where it says nothing else. `own` takes the words of
    /// an example, and says whether a word is one of them.
    pub fn read(
        substeps: Option<usize>,
        mut own: impl FnMut(&str, &mut Words) -> Result<bool, Failed>,
    ) -> Result<Self, Failed> {
        let overrides =
            Overrides { root: Some(RootChoice::Free), tension: Some(2.0), substeps, ..Overrides::default() };
        let mut o = Self {
            files: Vec::new(),
            seeds: vec![1],
            settings: Settings::default(),
            blind: false,
            ask: Ask { overrides, ..Ask::default() },
        };
        let mut words = Words(std::env::args().skip(1));
        while let Some(word) = words.0.next() {
            if own(&word, &mut words)? {
                continue;
            }
            let Self { settings, ask, .. } = &mut o;
            let (scales, over) = (&mut settings.scales, &mut ask.overrides);
            match word.as_str() {
                "--tension" => over.tension = Some(words.value(&word)?),
                "--substeps" => over.substeps = Some(words.value(&word)?),
                "--soles" => {
                    over.soles =
                        Some(SoleName::find(&words.value::<String>(&word)?).map_err(|e| e.to_string())?)
                }
                "--toes" => {
                    over.toes =
                        Some(ToesName::find(&words.value::<String>(&word)?).map_err(|e| e.to_string())?)
                }
                "--until" => over.span_s = Some((0.0, words.value(&word)?)),
                "--engine" => ask.engine = Some(words.value(&word)?),
                "--loop" => ask.loop_s = Some(words.value(&word)?),
                "--edit" => ask.edits.push(words.value(&word)?),
                "--off" => o.blind = true,
                "--draft" => *settings = Settings::draft(),
                "--seed" | "--seeds" => o.seeds = words.values(&word)?,
                "--horizon" => settings.horizon_s = words.value(&word)?,
                "--rollouts" => settings.rollouts = words.value(&word)?,
                "--beam" => settings.beam = words.value(&word)?,
                "--window" => settings.window_s = words.value(&word)?,
                "--stride" => settings.stride = words.value(&word)?,
                "--width" => settings.width = words.value(&word)?,
                "--com" => scales.com_m = words.value(&word)?,
                "--velocity" => scales.velocity_m_s = words.value(&word)?,
                "--capture" => scales.capture_m = words.value(&word)?,
                "--spin" => scales.spin_nms = words.value(&word)?,
                "--root" => scales.root_rad = words.value(&word)?,
                "--pose" => scales.pose_rad = words.value(&word)?,
                "--feet" => scales.feet_m = words.value(&word)?,
                "--stand" => scales.stand_m = words.value(&word)?,
                "--soft" => scales.soft = words.value(&word)?,
                "--impact" => scales.impact = words.value(&word)?,
                "--offset" => scales.offset = words.value(&word)?,
                "--change" => scales.change = words.value(&word)?,
                _ if word.starts_with("--") => return Err(format!("`{word}` is no option").into()),
                _ => o.files.extend(clips(word.into())?),
            }
        }
        if o.files.is_empty() {
            return Err("no clip, scene or folder is named".into());
        }
        Ok(o)
    }

    /// What a run with `seed` is asked for.
    pub fn ask(&self, seed: u64) -> Ask {
        let search = || LookAhead::As(Foreseen::Search(Settings { seed, ..self.settings }));
        let foresight = if self.blind { LookAhead::Off } else { search() };
        Ask { foresight, ..self.ask.clone() }
    }
}

/// The clips of a folder that step, in the order of their names; a file as it is.
fn clips(path: PathBuf) -> std::io::Result<Vec<PathBuf>> {
    if !path.is_dir() {
        return Ok(vec![path]);
    }
    let files = std::fs::read_dir(path)?.map(|e| Ok(e?.path())).collect::<std::io::Result<Vec<_>>>()?;
    let steps = |f: &PathBuf| {
        let stem = f.file_stem().unwrap_or_default().to_string_lossy();
        f.extension().is_some_and(|e| e == "bvh") && !STANDS.iter().any(|s| stem.starts_with(s))
    };
    let mut files: Vec<PathBuf> = files.into_iter().filter(steps).collect();
    files.sort();
    Ok(files)
}
