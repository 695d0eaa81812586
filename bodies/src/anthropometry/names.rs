//! What a joint's name says by itself: a side and a word.
//!
//! In: a name of any rig. Out: left, right or neither, and the part it stands for, if it is known. Case,
//! separators and namespaces do not matter.

use super::side::Side;

/// What a name says by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Word {
    Pelvis,
    Spine,
    Neck,
    Head,
    Clavicle,
    /// Collar bone where an arm is named too, upper arm elsewhere.
    Shoulder,
    UpperArm,
    Forearm,
    Hand,
    Finger,
    /// The root without a side, a thigh with one.
    Hip,
    Thigh,
    Shin,
    Foot,
    Toe,
    Helper,
}

/// Tokens that carry no meaning: namespaces, rig prefixes, suffixes.
const JUNK: [&str; 19] = [
    "mixamorig",
    "bip",
    "bip01",
    "bip001",
    "character",
    "character1",
    "cc",
    "base",
    "def",
    "org",
    "bn",
    "bone",
    "jnt",
    "joint",
    "skel",
    "rig",
    "robot",
    "actor",
    "j",
];

fn word(core: &str) -> Option<Word> {
    let bare = core.trim_end_matches(|c: char| c.is_ascii_digit());
    if core == "t4" {
        return Some(Word::Clavicle); // Xsens: `RightT4`
    }
    Some(match bare {
        "hips" | "pelvis" | "root" => Word::Pelvis,
        "hip" => Word::Hip,
        "spine" | "chest" | "upperchest" | "lowerback" | "upperback" | "back" | "abdomen" | "torso"
        | "waist" | "thorax" | "sternum" | "lowerspine" | "upperspine" | "spinelower" | "spineupper" => {
            Word::Spine
        }
        "neck" | "lowerneck" | "upperneck" | "necklower" | "neckupper" => Word::Neck,
        "head" => Word::Head,
        "collar" | "clavicle" | "collarbone" | "clav" | "scapula" => Word::Clavicle,
        "shoulder" => Word::Shoulder,
        "arm" | "upperarm" | "uparm" | "shldr" | "humerus" | "shldrbend" => Word::UpperArm,
        "forearm" | "lowerarm" | "lowarm" | "elbow" | "radius" | "forearmbend" => Word::Forearm,
        "hand" | "wrist" => Word::Hand,
        "thigh" | "upleg" | "upperleg" | "femur" | "thighbend" => Word::Thigh,
        "leg" | "shin" | "lowerleg" | "lowleg" | "calf" | "knee" | "shank" | "tibia" => Word::Shin,
        "foot" | "ankle" => Word::Foot,
        "toe" | "toebase" | "toes" | "ball" | "forefoot" | "metatarsals" => Word::Toe,
        "hipjoint" | "buttock" => Word::Helper,
        _ => {
            let finger = ["finger", "thumb", "index", "middle", "mid", "ring", "pinky", "little", "carpal"];
            if finger.iter().any(|f| bare.contains(f)) {
                return Some(Word::Finger);
            }
            return None;
        }
    })
}

fn vertebra(name: &str) -> Option<Word> {
    matches!(name, "l5" | "l4" | "l3" | "l1" | "t12" | "t10" | "t8" | "t1").then_some(Word::Spine)
}

/// Splits a name into lower-case tokens at separators and at changes from lower to upper case.
fn tokens(name: &str) -> Vec<String> {
    let name = name.rsplit([':', '|']).next().unwrap_or(name);
    let chars: Vec<char> = name.chars().collect();
    let mut out = vec![String::new()];
    for (i, &c) in chars.iter().enumerate() {
        if !c.is_alphanumeric() {
            out.push(String::new());
            continue;
        }
        let before = i.checked_sub(1).map(|j| chars[j]);
        let after = chars.get(i + 1);
        // "LeftArm" breaks before A; "LHipJoint" before H, since a lower-case letter follows it.
        let breaks = c.is_uppercase()
            && before.is_some_and(|b| {
                b.is_lowercase()
                    || b.is_numeric()
                    || (b.is_uppercase() && after.is_some_and(|a| a.is_lowercase()))
            });
        if breaks {
            out.push(String::new());
        }
        let token = out.len() - 1;
        out[token].extend(c.to_lowercase());
    }
    out.retain(|t| !t.is_empty());
    out
}

/// Side and word of a joint's name.
pub(super) fn read_name(name: &str) -> (Option<Side>, Option<Word>) {
    let mut parts = tokens(name);
    if let Some(w) = vertebra(&parts.concat()) {
        return (None, Some(w)); // "L5" is not a left 5
    }
    let side_of = |t: &str| match t {
        "l" | "left" => Some(Side::Left),
        "r" | "right" => Some(Side::Right),
        _ => None,
    };
    let mut side = None;
    if let Some(i) = parts.iter().position(|t| side_of(t).is_some()) {
        side = side_of(&parts[i]);
        parts.remove(i);
    }
    let lookup = |parts: &[String]| {
        word(&parts.concat()).or_else(|| {
            let kept: Vec<_> = parts.iter().filter(|t| !JUNK.contains(&t.as_str())).cloned().collect();
            word(&kept.concat())
        })
    };
    if let Some(w) = lookup(&parts) {
        return (side, Some(w));
    }
    if side.is_none() {
        // names without any capital or separator: "lhand", "rightupleg"
        let all = parts.concat();
        for (prefix, s) in
            [("left", Side::Left), ("right", Side::Right), ("l", Side::Left), ("r", Side::Right)]
        {
            if let Some(w) = all.strip_prefix(prefix).and_then(word) {
                return (Some(s), Some(w));
            }
        }
    }
    (side, None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_many_rigs_are_read() {
        use Side::{Left as L, Right as R};
        for (name, side, want) in [
            ("LHipJoint", Some(L), Word::Helper),
            ("LeftUpLeg", Some(L), Word::Thigh),
            ("LeftToeBase", Some(L), Word::Toe),
            ("LThumb", Some(L), Word::Finger),
            ("LeftHandIndex1", Some(L), Word::Finger),
            ("mixamorig:LeftArm", Some(L), Word::UpperArm),
            ("mixamorig_RightForeArm", Some(R), Word::Forearm),
            ("RightUpperLeg", Some(R), Word::Thigh),
            ("RightT4", Some(R), Word::Clavicle),
            ("L5", None, Word::Spine),
            ("T12", None, Word::Spine),
            ("rShldr", Some(R), Word::UpperArm),
            ("lButtock", Some(L), Word::Helper),
            ("upperarm_l", Some(L), Word::UpperArm),
            ("calf_r", Some(R), Word::Shin),
            ("Bip01 L Thigh", Some(L), Word::Thigh),
            ("Bip001 R UpperArm", Some(R), Word::UpperArm),
            ("lhand", Some(L), Word::Hand),
            ("lowerback", None, Word::Spine),
            ("LEFT_FOOT", Some(L), Word::Foot),
            ("shin.R", Some(R), Word::Shin),
            ("ball_l", Some(L), Word::Toe),
            ("LowerBack", None, Word::Spine),
            ("Neck1", None, Word::Neck),
            ("elbow_r", Some(R), Word::Forearm),
            ("hip_l", Some(L), Word::Hip),
        ] {
            assert_eq!(read_name(name), (side, Some(want)), "{name}");
        }
        assert_eq!(read_name("Prop").1, None);
        assert_eq!(read_name("leftEye").1, None);
    }
}
