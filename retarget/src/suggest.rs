//! Which frames to key next.
//!
//! In: a learned mapping and a human motion. Out: the frames of which the model is least sure, by
//! [`learn::suggest()`]: each one chosen counts as keyed for the next, so that five of them are not five neighbours.

use motion::{Clip, Kinematics};
use nalgebra::DMatrix;

use crate::mapping::Mapping;
use crate::{Performer, RetargetError};

impl Mapping {
    /// Up to `count` frames of `human` (of the performer, ground at 0), the most wanted first.
    ///
    /// # Errors
    /// As [`Mapping::fits`]; a pose that is not finite.
    pub fn suggest(
        &self,
        performer: &Performer,
        human: &Clip,
        count: usize,
    ) -> Result<Vec<usize>, RetargetError> {
        self.fits(performer)?;
        let skeleton = &performer.character.skeleton;
        let mut k = Kinematics::new(skeleton, &skeleton.zero_pose());
        let mut frames = DMatrix::zeros(human.frames(), performer.features.len());
        let mut row = vec![0.0; performer.features.len()];
        for i in 0..human.frames() {
            k.update(skeleton, human.pose(i));
            performer.features.read(&k, 0.0, &mut row);
            frames.row_mut(i).iter_mut().zip(&row).for_each(|(to, from)| *to = *from);
        }
        self.suggest_among(&frames, count)
    }

    /// Up to `count` of these human poses, given by their feature points (poses × coordinates), the most wanted
    /// first.
    ///
    /// # Errors
    /// A wrong number of coordinates, or one that is not finite.
    pub fn suggest_among(&self, poses: &DMatrix<f64>, count: usize) -> Result<Vec<usize>, RetargetError> {
        let named = learn::suggest(&self.model, poses, count);
        let named = named.map_err(|e| RetargetError::Learn(e.to_string()))?;
        Ok(named.into_iter().map(|s| s.frame).collect())
    }
}
