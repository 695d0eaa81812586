//! The ground that push maps and costs of tuning need: level, still, under gravity that points down.

use takes::Conditions;

/// Level ground that stays. See the module header.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LevelGround {
    /// Its height, m.
    pub height_m: f64,
    /// Gravity towards it, m/s².
    pub gravity_m_s2: f64,
}

impl LevelGround {
    /// That of a take.
    ///
    /// # Errors
    /// What it is instead.
    pub fn of(conditions: &Conditions) -> Result<Self, &'static str> {
        let ground = conditions.physics.ground.ok_or("it has no ground")?;
        if !conditions.tilts.is_empty() {
            return Err("its ground tilts");
        }
        let gravity = conditions.physics.gravity_down_m_s2();
        let gravity_m_s2 = gravity.ok_or("its gravity does not point down")?;
        Ok(Self { height_m: ground.height_m, gravity_m_s2 })
    }
}
