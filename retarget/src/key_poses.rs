//! Key poses: pairs of a human pose and the character pose that means the same.
//!
//! In: poses of performers and of one puppet. Out: the two observation matrices Y and Z of \[YAH10, §4.1\]. Pairs
//! may come from several performers: feature points make their poses comparable.

use std::sync::Arc;

use motion::Clip;
use nalgebra::DMatrix;

use crate::{Performer, Puppet, RetargetError};

/// One pair.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyPose {
    /// Name, for messages and reports.
    pub name: String,
    /// The performance it was taken from (`happy`, `sad`, …): what leave-one-performance-out leaves out.
    pub group: String,
    /// Whose pose it is.
    pub performer: Arc<Performer>,
    /// The human pose (`nq` of the performer), standing on ground at height 0.
    pub human: Vec<f64>,
    /// The character's pose (`nq` of the puppet), standing on ground at height 0.
    pub character: Vec<f64>,
}

/// All pairs of one puppet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KeyPoses {
    /// The pairs, in the order of the file.
    pub pairs: Vec<KeyPose>,
}

/// Pairs whose human feature points differ by less than this RMS are the same human pose, m.
pub const SAME_HUMAN_M: f64 = 0.005;
/// Pairs of the same human pose whose character points differ by more than this RMS contradict, m.
pub const SAME_CHARACTER_M: f64 = 0.005;
/// Fewest pairs from which anything is learned.
pub const FEWEST: usize = 3;

impl KeyPose {
    /// A pair whose human pose is a frame of a clip.
    ///
    /// The clip must be of the performer's skeleton, of which some joints may be welded; `ground_m` is the
    /// height of the ground in the clip.
    ///
    /// # Errors
    /// A frame out of range, a clip of another skeleton.
    pub fn of_frame(
        name: &str,
        group: &str,
        performer: &Arc<Performer>,
        clip: &Clip,
        frame: usize,
        ground_m: f64,
        character: Vec<f64>,
    ) -> Result<Self, RetargetError> {
        if frame >= clip.frames() {
            return Err(RetargetError::Frame { pair: name.into(), frame, frames: clip.frames() });
        }
        let skeleton = &performer.character.skeleton;
        let map = bodies::PoseMap::of_clip(clip, skeleton)?;
        let mut human = vec![0.0; skeleton.nq()];
        map.to_character(clip.pose(frame), &mut human);
        let up = skeleton.q_at(0) + 1;
        human[up] -= ground_m;
        Ok(Self { name: name.into(), group: group.into(), performer: performer.clone(), human, character })
    }
}

impl KeyPoses {
    /// The observation matrices: human features `N × D_Y` and character features `N × D_Z`.
    pub fn observations(&self, puppet: &Puppet) -> (DMatrix<f64>, DMatrix<f64>) {
        let rows = |of: &dyn Fn(&KeyPose) -> Vec<f64>| -> DMatrix<f64> {
            let rows: Vec<Vec<f64>> = self.pairs.iter().map(of).collect();
            let columns = rows.first().map_or(0, Vec::len);
            DMatrix::from_fn(rows.len(), columns, |i, j| rows[i][j])
        };
        let y = rows(&|p| p.performer.features.of_pose(&p.performer.character.skeleton, &p.human, 0.0));
        let z = rows(&|p| puppet.features.of_pose(&puppet.character.skeleton, &p.character, 0.0));
        (y, z)
    }

    /// Checks that there are enough pairs, that they fit the puppet and one another.
    ///
    /// # Errors
    /// Too few; a pose of the wrong length; other feature points than the first pair's; the same pair twice;
    /// the same human pose with different character poses.
    pub fn check(&self, puppet: &Puppet) -> Result<(), RetargetError> {
        let found = self.pairs.len();
        if found < FEWEST {
            return Err(RetargetError::TooFewKeyPoses { found, least: FEWEST });
        }
        let names = |p: &KeyPose| -> Vec<String> {
            p.performer.features.points.iter().map(|x| x.name.clone()).collect()
        };
        let first = names(&self.pairs[0]);
        for p in &self.pairs {
            let length = |found: usize, needed: usize, whose: &'static str| {
                (found == needed).then_some(()).ok_or(RetargetError::PoseLength {
                    pair: p.name.clone(),
                    whose,
                    found,
                    needed,
                })
            };
            length(p.human.len(), p.performer.character.skeleton.nq(), "human")?;
            length(p.character.len(), puppet.character.skeleton.nq(), "character")?;
            let own = names(p);
            if own != first {
                let missing = first.iter().filter(|n| !own.contains(n)).cloned().collect();
                return Err(RetargetError::MarkersMissing { whose: p.name.clone(), missing });
            }
        }
        let (y, z) = self.observations(puppet);
        let rms = |m: &DMatrix<f64>, i: usize, j: usize| {
            ((m.row(i) - m.row(j)).norm_squared() * 3.0 / m.ncols() as f64).sqrt()
        };
        for i in 0..found {
            for j in 0..i {
                if rms(&y, i, j) >= SAME_HUMAN_M {
                    continue;
                }
                let (first, second) = (self.pairs[j].name.clone(), self.pairs[i].name.clone());
                let apart_mm = 1e3 * rms(&z, i, j);
                return Err(if apart_mm > 1e3 * SAME_CHARACTER_M {
                    RetargetError::Contradiction { first, second, apart_mm }
                } else {
                    RetargetError::Duplicate { first, second }
                });
            }
        }
        Ok(())
    }
}
