//! Bytes to [`Bvh`]: liberal in layout, strict in meaning.
//!
//! Accepted: any channel order and count up to six, LF, CR LF or CR, a byte order mark, no final newline,
//! everything on one line, keywords in any case, names with spaces and colons, joints without channels,
//! without children and without `End Site`, frames broken over lines.
//! Refused, with line and column: what could be read in two ways or not at all. Among it numbers
//! without white space between them (`0.0-1.0`: the writer that lost the blank before a minus sign has
//! lost it elsewhere too, where no sign shows it), a number of values other than `Frames` says, a second
//! `ROOT` (its channels share the rows of the first; split the file).
//!
//! Memory is bounded by the size of the text, whatever counts it states.

use thiserror::Error;

use super::number::scan;
use super::{Bvh, BvhJoint, Channel};
use crate::limits::NUMBER;

/// What is wrong and where.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{fault}\n  --> {line}:{column}")]
pub struct BvhError {
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1, in characters.
    pub column: usize,
    /// What was found and what is allowed.
    pub fault: BvhFault,
}

/// What is wrong with a BVH text.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum BvhFault {
    /// Nothing, or only white space.
    #[error("the file is empty; a BVH file starts with `HIERARCHY`")]
    Empty,
    /// Another word than the grammar allows.
    #[error("found {found}, expected {expected}")]
    Unexpected {
        /// What stands there.
        found: String,
        /// What may stand there.
        expected: &'static str,
    },
    /// `ROOT` or `JOINT` without a name.
    #[error("`{keyword}` has no name; a name follows it on the same line")]
    NoName {
        /// The keyword.
        keyword: &'static str,
    },
    /// A second tree.
    #[error("second root `{name}`; a file holds one ROOT: split this one into one file per tree")]
    SecondRoot {
        /// Its name.
        name: String,
    },
    /// A channel count out of range.
    #[error("CHANNELS {found}; a joint has 0 to 6")]
    ChannelCount {
        /// The word found.
        found: String,
    },
    /// An unknown channel.
    #[error(
        "unknown channel {found}; allowed are Xposition Yposition Zposition Xrotation Yrotation Zrotation"
    )]
    UnknownChannel {
        /// The word found.
        found: String,
    },
    /// A coordinate given twice.
    #[error("channel {found} twice in one joint")]
    RepeatedChannel {
        /// The word found.
        found: String,
    },
    /// No joint has a channel.
    #[error("no joint has a channel, so there is nothing to read from the frames")]
    NoChannels,
    /// A word that is not a number.
    #[error("{found} is not a number; numbers are decimal and white space stands between them")]
    NotNumber {
        /// The word found.
        found: String,
    },
    /// NaN or infinite.
    #[error("{found} is not a finite number")]
    NotFinite {
        /// The word found.
        found: String,
    },
    /// Beyond 1e12 either way.
    #[error("{found} is too large a number; allowed: up to 1e12 either way")]
    TooLarge {
        /// The word found.
        found: String,
    },
    /// A frame count that is no count.
    #[error("Frames: {found}; expected a whole number, 0 or more")]
    FrameCount {
        /// The word found.
        found: String,
    },
    /// A frame time that gives no rate.
    #[error("Frame Time: {found} s; expected a number from 1e-6 to 1e6")]
    FrameTime {
        /// The word found.
        found: String,
    },
    /// The file ends too early.
    #[error("{frames} frames of {channels} values are stated, the file ends after {values} values ({})", rows(*values, *channels, *odd_line))]
    TooFewValues {
        /// Frames stated.
        frames: u64,
        /// Values per frame.
        channels: usize,
        /// Values found.
        values: usize,
        /// First line with another number of values, and that number.
        odd_line: Option<(usize, usize)>,
    },
    /// The file goes on after the last frame.
    #[error("{frames} frames of {channels} values are stated, more values follow ({})", rows(*values, *channels, *odd_line))]
    TooManyValues {
        /// Frames stated.
        frames: u64,
        /// Values per frame.
        channels: usize,
        /// Values found.
        values: usize,
        /// First line with another number of values, and that number.
        odd_line: Option<(usize, usize)>,
    },
}

/// What the values found amount to.
fn rows(values: usize, channels: usize, odd_line: Option<(usize, usize)>) -> String {
    let mut text = format!("found {} whole frames", values / channels.max(1));
    if !values.is_multiple_of(channels.max(1)) {
        text += &format!(" and {} values", values % channels.max(1));
    }
    if let Some((line, count)) = odd_line {
        text += &format!("; line {line} has {count} values");
    }
    text
}

impl Bvh {
    /// Reads a file's bytes; names that are not UTF-8 get replacement characters.
    ///
    /// # Errors
    /// [`BvhError`] with line, column, what was found and what is allowed.
    ///
    /// # Examples
    /// ```
    /// # use formats::bvh::Bvh;
    /// let text = "HIERARCHY ROOT hip { OFFSET 0 0 0 CHANNELS 1 Xrotation }
    ///     MOTION Frames: 2 Frame Time: 0.04  10 +2.5e1";
    /// let bvh = Bvh::parse(text.as_bytes()).unwrap();
    /// assert_eq!(bvh.motion, [10.0, 25.0]);
    /// ```
    pub fn parse(bytes: &[u8]) -> Result<Self, BvhError> {
        let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        Reader { text, at: 0 }.file().map_err(|(at, fault)| {
            let (line, column) = place(text, at);
            BvhError { line, column, fault }
        })
    }
}

/// A fault at a byte position.
type Fault = (usize, BvhFault);

struct Reader<'a> {
    text: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    fn file(&mut self) -> Result<Bvh, Fault> {
        self.skip_white();
        if self.at == self.text.len() {
            return Err((self.at, BvhFault::Empty));
        }
        self.keyword("HIERARCHY", "`HIERARCHY`")?;
        self.keyword("ROOT", "`ROOT`")?;
        let mut joints = self.tree()?;
        self.skip_white();
        let at = self.at;
        if self.word().eq_ignore_ascii_case(b"ROOT") {
            let name = self.name("ROOT")?;
            return Err((at, BvhFault::SecondRoot { name }));
        }
        self.at = at;
        self.keyword("MOTION", "`MOTION`")?;
        let mut channels = 0;
        for joint in &mut joints {
            joint.channels_at = channels;
            channels += joint.channels.len();
        }
        if channels == 0 {
            return Err((at, BvhFault::NoChannels));
        }
        self.label("Frames")?;
        let frames = self.frame_count()?;
        self.label("Frame")?;
        self.label("Time")?;
        let (frame_time_s, frame_time_digit_s) = self.frame_time()?;
        let motion = self.motion(frames, channels)?;
        Ok(Bvh {
            joints,
            frame_time_s,
            frame_time_digit_s,
            channels,
            frames: motion.len() / channels,
            motion,
        })
    }

    /// The joints from the root's name to its closing brace. A loop, so that depth costs no stack.
    fn tree(&mut self) -> Result<Vec<BvhJoint>, Fault> {
        const INSIDE: &str = "`OFFSET`, `CHANNELS`, `JOINT`, `End Site` or `}`";
        let mut joints = vec![self.joint("ROOT", None)?];
        let mut has = vec![(false, false)]; // OFFSET, CHANNELS
        let mut open = vec![0];
        while let Some(&j) = open.last() {
            self.skip_white();
            let at = self.at;
            let word = self.word();
            let is = |keyword: &str| word.eq_ignore_ascii_case(keyword.as_bytes());
            if is("OFFSET") && !has[j].0 {
                joints[j].offset = self.offset()?;
                has[j].0 = true;
            } else if is("CHANNELS") && !has[j].1 {
                joints[j].channels = self.channels()?;
                has[j].1 = true;
            } else if !has[j].0 {
                return Err(self.unexpected(at, "`OFFSET`"));
            } else if is("JOINT") {
                joints.push(self.joint("JOINT", Some(j))?);
                has.push((false, false));
                open.push(joints.len() - 1);
            } else if is("End") {
                let end = self.end_site()?;
                joints[j].ends.push(end);
            } else if is("}") {
                open.pop();
            } else {
                return Err(self.unexpected(at, INSIDE));
            }
        }
        Ok(joints)
    }

    fn joint(&mut self, keyword: &'static str, parent: Option<usize>) -> Result<BvhJoint, Fault> {
        let name = self.name(keyword)?;
        self.keyword("{", "`{`")?;
        Ok(BvhJoint {
            name,
            parent,
            offset: [0.0; 3],
            channels: Vec::new(),
            channels_at: 0,
            ends: Vec::new(),
        })
    }

    /// A name runs to the end of the line or to a brace.
    fn name(&mut self, keyword: &'static str) -> Result<String, Fault> {
        let at = self.at;
        let rest = &self.text[at..];
        let length = rest.iter().position(|c| matches!(c, b'\n' | b'\r' | b'{' | b'}')).unwrap_or(rest.len());
        self.at += length;
        let name = String::from_utf8_lossy(&rest[..length]);
        let name = name.trim();
        if name.is_empty() {
            return Err((at, BvhFault::NoName { keyword }));
        }
        Ok(name.to_owned())
    }

    fn offset(&mut self) -> Result<[f64; 3], Fault> {
        Ok([self.number()?, self.number()?, self.number()?])
    }

    fn end_site(&mut self) -> Result<[f64; 3], Fault> {
        let rest = &self.text[self.at..];
        self.at += rest.iter().position(|c| matches!(c, b'\n' | b'\r' | b'{' | b'}')).unwrap_or(rest.len());
        self.keyword("{", "`{`")?;
        self.keyword("OFFSET", "`OFFSET`")?;
        let offset = self.offset()?;
        self.keyword("}", "`}`")?;
        Ok(offset)
    }

    fn channels(&mut self) -> Result<Vec<Channel>, Fault> {
        self.skip_white();
        let at = self.at;
        let count =
            std::str::from_utf8(self.word()).ok().and_then(|w| w.parse().ok()).filter(|&n: &usize| n <= 6);
        let Some(count) = count else {
            return Err((at, BvhFault::ChannelCount { found: self.shown(at) }));
        };
        let mut channels = Vec::with_capacity(count);
        for _ in 0..count {
            self.skip_white();
            let at = self.at;
            let word = self.word().to_ascii_lowercase();
            let channel = word.split_first().and_then(|(axis, kind)| {
                let axis = axis.checked_sub(b'x').filter(|&a| a < 3)? as usize;
                match kind {
                    b"position" => Some(Channel::Position(axis)),
                    b"rotation" => Some(Channel::Rotation(axis)),
                    _ => None,
                }
            });
            let Some(channel) = channel else {
                return Err((at, BvhFault::UnknownChannel { found: self.shown(at) }));
            };
            // A repeated rotation (Z X Z) is a product like any other; a repeated coordinate is not.
            if matches!(channel, Channel::Position(_)) && channels.contains(&channel) {
                return Err((at, BvhFault::RepeatedChannel { found: self.shown(at) }));
            }
            channels.push(channel);
        }
        Ok(channels)
    }

    fn frame_count(&mut self) -> Result<u64, Fault> {
        self.skip_white();
        let at = self.at;
        let word = std::str::from_utf8(self.word()).ok().and_then(|w| w.parse().ok());
        word.ok_or_else(|| (at, BvhFault::FrameCount { found: self.shown(at) }))
    }

    /// The frame time and the weight of its last printed digit.
    fn frame_time(&mut self) -> Result<(f64, f64), Fault> {
        self.skip_white();
        let at = self.at;
        let word = String::from_utf8_lossy(self.word()).to_ascii_lowercase();
        let value = scan(self.text, at).filter(|&(_, end)| end == self.at).map(|(value, _)| value);
        let Some(value) = value.filter(|v| (1e-6..=1e6).contains(v)) else {
            return Err((at, BvhFault::FrameTime { found: self.shown(at) }));
        };
        let (digits, power) = word.split_once('e').unwrap_or((&word, "0"));
        let decimals = digits.split_once('.').map_or(0, |(_, fraction)| fraction.len());
        let exponent = power.parse::<f64>().unwrap_or(0.0) - decimals as f64;
        Ok((value, 10f64.powf(exponent)))
    }

    fn motion(&mut self, frames: u64, channels: usize) -> Result<Vec<f64>, Fault> {
        let text = self.text;
        let start = self.at;
        let stated = usize::try_from(frames).unwrap_or(usize::MAX).saturating_mul(channels);
        // A value takes two bytes at least: what the text can hold bounds what is reserved.
        let mut values = Vec::with_capacity(stated.min((text.len() - start) / 2 + 1));
        let mut i = start;
        loop {
            while text.get(i).is_some_and(|&c| is_white(c)) {
                i += 1;
            }
            if i == text.len() {
                break;
            }
            let Some((value, end)) =
                scan(text, i).filter(|&(_, end)| text.get(end).is_none_or(|&c| is_white(c)))
            else {
                return Err(self.bad_number(i));
            };
            if !is_usual(value) {
                return Err((i, self.unusual(i, value)));
            }
            if values.len() == stated {
                let values = stated + count_words(&text[i..]);
                let odd_line = self.odd_line(start, channels);
                return Err((i, BvhFault::TooManyValues { frames, channels, values, odd_line }));
            }
            values.push(value);
            i = end;
        }
        if values.len() < stated {
            let odd_line = self.odd_line(start, channels);
            return Err((i, BvhFault::TooFewValues { frames, channels, values: values.len(), odd_line }));
        }
        self.at = i;
        Ok(values)
    }

    /// First line after `start` whose number of values is not `channels`, if most lines have as many.
    fn odd_line(&self, start: usize, channels: usize) -> Option<(usize, usize)> {
        let (mut at, mut odd, mut even) = (start, Vec::new(), 0);
        let mut line_number = place(self.text, start).0;
        while at < self.text.len() {
            let rest = &self.text[at..];
            let length = rest.iter().position(|c| matches!(c, b'\n' | b'\r')).unwrap_or(rest.len());
            match count_words(&rest[..length]) {
                0 => {}
                n if n == channels => even += 1,
                n => odd.push((line_number, n)),
            }
            at += length + if rest[length..].starts_with(b"\r\n") { 2 } else { 1 };
            line_number += 1;
        }
        odd.first().copied().filter(|_| even >= odd.len())
    }

    fn number(&mut self) -> Result<f64, Fault> {
        self.skip_white();
        let at = self.at;
        let ends = |c: u8| is_white(c) || matches!(c, b'{' | b'}');
        let Some((value, end)) =
            scan(self.text, at).filter(|&(_, end)| self.text.get(end).is_none_or(|&c| ends(c)))
        else {
            return Err(self.bad_number(at));
        };
        if !is_usual(value) {
            return Err((at, self.unusual(at, value)));
        }
        self.at = end;
        Ok(value)
    }

    /// What is wrong with a number that [`is_usual`] refuses.
    fn unusual(&self, at: usize, value: f64) -> BvhFault {
        let found = self.shown(at);
        if value.is_finite() { BvhFault::TooLarge { found } } else { BvhFault::NotFinite { found } }
    }

    fn bad_number(&self, at: usize) -> Fault {
        let mut word = Reader { text: self.text, at };
        let lower = word.word().to_ascii_lowercase();
        let unsigned = lower.strip_prefix(b"-").or(lower.strip_prefix(b"+")).unwrap_or(&lower);
        let found = self.shown(at);
        if [&b"nan"[..], b"inf", b"1.#"].iter().any(|p| unsigned.starts_with(p)) {
            (at, BvhFault::NotFinite { found })
        } else {
            (at, BvhFault::NotNumber { found })
        }
    }

    fn keyword(&mut self, keyword: &str, expected: &'static str) -> Result<(), Fault> {
        self.skip_white();
        let at = self.at;
        if self.word().eq_ignore_ascii_case(keyword.as_bytes()) {
            Ok(())
        } else {
            Err(self.unexpected(at, expected))
        }
    }

    /// A word of the motion header and the colon after it, with or without white space between them.
    fn label(&mut self, label: &'static str) -> Result<(), Fault> {
        self.skip_white();
        let at = self.at;
        let rest = &self.text[at..];
        if !rest.get(..label.len()).is_some_and(|w| w.eq_ignore_ascii_case(label.as_bytes())) {
            let expected = if label == "Frames" { "`Frames:`" } else { "`Frame Time:`" };
            return Err(self.unexpected(at, expected));
        }
        self.at += label.len();
        self.skip_white();
        if self.text.get(self.at) == Some(&b':') {
            self.at += 1;
        }
        Ok(())
    }

    /// The bytes up to white space or a brace; a brace by itself.
    fn word(&mut self) -> &[u8] {
        let start = self.at;
        while let Some(&c) = self.text.get(self.at) {
            let brace = matches!(c, b'{' | b'}');
            if is_white(c) || brace && self.at > start {
                break;
            }
            self.at += 1;
            if brace {
                break;
            }
        }
        &self.text[start..self.at]
    }

    fn skip_white(&mut self) {
        while self.text.get(self.at).is_some_and(|&c| is_white(c)) {
            self.at += 1;
        }
    }

    fn unexpected(&self, at: usize, expected: &'static str) -> Fault {
        (at, BvhFault::Unexpected { found: self.shown(at), expected })
    }

    /// The word at a position as a message shows it.
    fn shown(&self, at: usize) -> String {
        let mut reader = Reader { text: self.text, at };
        let word = reader.word();
        if word.is_empty() {
            return if at >= self.text.len() { "the end of the file".into() } else { "nothing".into() };
        }
        let text = String::from_utf8_lossy(word);
        let short: String =
            text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).take(40).collect();
        if short.len() < text.len() { format!("`{short}…`") } else { format!("`{short}`") }
    }
}

/// Whether a number is one that a motion can have: finite, and no larger than what is still finite in any unit and any sum.
fn is_usual(value: f64) -> bool {
    value.abs() <= NUMBER
}

fn is_white(c: u8) -> bool {
    matches!(c, b' ' | b'\t' | b'\n' | b'\r' | 0x0b | 0x0c)
}

fn count_words(text: &[u8]) -> usize {
    text.split(|&c| is_white(c)).filter(|word| !word.is_empty()).count()
}

/// Line and column of a byte, from 1; LF, CR LF and CR end a line, columns count characters.
fn place(text: &[u8], at: usize) -> (usize, usize) {
    let (mut line, mut start) = (1, 0);
    for (i, &c) in text[..at].iter().enumerate() {
        if c == b'\n' || c == b'\r' && text.get(i + 1) != Some(&b'\n') {
            line += 1;
            start = i + 1;
        }
    }
    // continuation bytes of UTF-8 are 10xxxxxx
    (line, 1 + text[start..at].iter().filter(|&&c| c & 0xC0 != 0x80).count())
}
