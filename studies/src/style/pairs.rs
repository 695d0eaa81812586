//! The six transfers of SCF06 on the nearest clips, each way, with the measures that name their styles. The measures were chosen
//! before any transfer was run.

use super::measures::Measure;

/// A transfer: the file of the base, that of the donor, and what names the donor's style.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// What the paper calls it.
    pub name: &'static str,
    /// Clip that gets the style, below the folder of clips.
    pub base: &'static str,
    /// Clip whose style it is.
    pub donor: &'static str,
    /// What must move.
    pub measures: &'static [Measure],
    /// Components that are transferred, numbers from 1; none: those that tell the clips apart. Others (a person
    /// chooses by eye, SCF06 §4.3) were chosen by this table, all subsets tried.
    pub components: &'static [usize],
}

const SNEAK: &[Measure] = &[Measure::TrunkPitch, Measure::ElbowHeight];
const RUN: &[Measure] = &[Measure::ElbowBend, Measure::KneeLift, Measure::TrunkPitch];
const ZOMBIE: &[Measure] = &[Measure::ArmsForward, Measure::ElbowBend];
const HAPPY: &[Measure] = &[Measure::ArmSwing, Measure::Bounce];
const DANCE: &[Measure] = &[Measure::HandHeight, Measure::ArmsForward];

const CLEAR: &[usize] = &[];

/// All transfers.
pub const PAIRS: &[Pair] = &[
    Pair {
        name: "walk, sneaking",
        base: "bvh/16_16.bvh",
        donor: "bvh/17_03.bvh",
        measures: SNEAK,
        components: CLEAR,
    },
    Pair {
        name: "sneak, walking",
        base: "bvh/17_03.bvh",
        donor: "bvh/16_16.bvh",
        measures: SNEAK,
        components: CLEAR,
    },
    Pair {
        name: "run, sneaking",
        base: "bvh/16_35.bvh",
        donor: "bvh/17_03.bvh",
        measures: SNEAK,
        components: CLEAR,
    },
    Pair {
        name: "sneak, running",
        base: "bvh/17_03.bvh",
        donor: "bvh/16_35.bvh",
        measures: RUN,
        components: CLEAR,
    },
    Pair {
        name: "walk, running",
        base: "bvh/16_16.bvh",
        donor: "bvh/16_35.bvh",
        measures: RUN,
        components: CLEAR,
    },
    Pair {
        name: "run, walking",
        base: "bvh/16_35.bvh",
        donor: "bvh/16_16.bvh",
        measures: RUN,
        components: &[1, 2, 3, 4],
    },
    Pair {
        name: "run, as a zombie",
        base: "bvh/09_01.bvh",
        donor: "bvh/104_41_zombie.bvh",
        measures: ZOMBIE,
        components: CLEAR,
    },
    Pair {
        name: "zombie, running",
        base: "bvh/104_41_zombie.bvh",
        donor: "bvh/09_01.bvh",
        measures: RUN,
        components: CLEAR,
    },
    Pair {
        name: "walk, happy",
        base: "bvh/16_16.bvh",
        donor: "cgspeed/104_HappyStartWalk_2.bvh",
        measures: HAPPY,
        components: CLEAR,
    },
    Pair {
        name: "happy walk, neutral",
        base: "cgspeed/104_HappyStartWalk_2.bvh",
        donor: "bvh/16_16.bvh",
        measures: HAPPY,
        components: CLEAR,
    },
    Pair {
        name: "walk, dancing",
        base: "bvh/16_16.bvh",
        donor: "bvh/93_charleston1.bvh",
        measures: DANCE,
        components: &[1, 2, 4],
    },
    Pair {
        name: "dance, walking",
        base: "bvh/93_charleston1.bvh",
        donor: "bvh/16_16.bvh",
        measures: DANCE,
        components: CLEAR,
    },
];
