//! Props of a scene or of a command line, checked.
//!
//! In: `Box(…)` and `Ramp(…)`. Out: a [`Prop`] in SI units, or an error at the very value.

use bodies::Prop;
use motion::Vec3;

use crate::schema::{NamedWith, PropRon};
use crate::{SceneError, Source};

/// Reads props as a scene has them.
pub(crate) fn props(source: &Source, at: &str, ron: &[NamedWith<PropRon>]) -> Result<Vec<Prop>, SceneError> {
    let mut out: Vec<Prop> = Vec::new();
    for (i, NamedWith(ron)) in ron.iter().enumerate() {
        let prop = prop(source, &format!("{at}[{i}]"), i, ron)?;
        if out.iter().any(|p| p.name == prop.name) {
            let message = format!("two props are named `{}`; allowed: a name for each", prop.name);
            return Err(source.error(&format!("{at}[{i}].name"), message));
        }
        out.push(prop);
    }
    Ok(out)
}

/// Reads a prop from a text such as `Box(at_m: (0, 0, 0.5), size_m: (0.4, 0.2, 0.3))`.
///
/// * `number`: how many there are before it; its name, where the text gives none
///
/// # Errors
/// Syntax, numbers out of range: at their place.
///
/// # Examples
/// ```
/// let step = scenes::prop_of("Box(at_m: (0, 0, 0.5), size_m: (0.4, 0.2, 0.3))", 0).unwrap();
/// assert_eq!((step.name.as_str(), step.half.y), ("box 1", 0.1));
/// assert!(scenes::prop_of("Ramp(at_m: (0, 0, 1), length_m: 2, width_m: 1, rise_deg: 95)", 0).is_err());
/// ```
pub fn prop_of(text: &str, number: usize) -> Result<Prop, SceneError> {
    let source = Source::new("--prop", text);
    let NamedWith(ron): NamedWith<PropRon> = source.parse()?;
    prop(&source, "", number, &ron)
}

fn prop(source: &Source, at: &str, number: usize, ron: &PropRon) -> Result<Prop, SceneError> {
    let at = |field: &str| if at.is_empty() { field.to_owned() } else { format!("{at}.{field}") };
    let within = |field: &str, x: f64, lo: f64, hi: f64, unit: &str| {
        if (lo..=hi).contains(&x) {
            return Ok(x);
        }
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        Err(source.error(&at(field), format!("{field} is {x}{unit}; allowed: {lo} to {hi}{unit}")))
    };
    let place = |(x, y, z): (f64, f64, f64)| -> Result<Vec3, SceneError> {
        let far = |x| within("at_m", x, -1e3, 1e3, "m");
        Ok(Vec3::new(far(x)?, far(y)?, far(z)?))
    };
    let long = |field, x| within(field, x, 0.01, 100.0, "m");
    let angle = |field, x| within(field, x, -360.0, 360.0, "°").map(f64::to_radians);
    let name = |name: &Option<String>, kind: &str| match name {
        None => Ok(format!("{kind} {}", number + 1)),
        Some(name) if name.trim().is_empty() => {
            Err(source.error(&at("name"), "the name of the prop is empty; allowed: a name, or none"))
        }
        Some(name) => Ok(name.clone()),
    };
    match ron {
        PropRon::Box(b) => {
            let (x, y, z) = b.size_m;
            let size = Vec3::new(long("size_m", x)?, long("size_m", y)?, long("size_m", z)?);
            let friction = within("friction", b.friction, 0.0, 2.0, "")?;
            let turn = angle("turn_deg", b.turn_deg)?;
            Ok(Prop::upright(&name(&b.name, "box")?, place(b.at_m)?, size, turn, friction))
        }
        PropRon::Ramp(r) => {
            let size =
                (long("length_m", r.length_m)?, long("width_m", r.width_m)?, long("height_m", r.height_m)?);
            let rise = within("rise_deg", r.rise_deg, 0.0, 80.0, "°")?.to_radians();
            let friction = within("friction", r.friction, 0.0, 2.0, "")?;
            let slope = (rise, angle("towards_deg", r.towards_deg)?);
            Ok(Prop::ramp(&name(&r.name, "ramp")?, place(r.at_m)?, size, slope, friction))
        }
    }
}
