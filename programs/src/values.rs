//! Joint values as programs have them: degrees, metres, lists of three numbers.
//!
//! A hinge is a number of degrees, a slide or a coordinate of the root a number of metres, a ball three angles `[x, y, z]` in degrees as
//! scenes write them ([`motion::rotation::quat_from_deg`]). A turn is a number of degrees about a hinge's axis, or of a ball the
//! rotation vector `[x, y, z]` in degrees along the axes of its zero frame.

use motion::rotation::{deg_from_quat, exp, log, quat_from_deg};
use motion::{Dof, Joint, Quat, Skeleton, Value, Vec3};
use rhai::{Dynamic, EvalAltResult};

use crate::error::refuse;

/// What a fallible function of the language gives.
pub(crate) type Answer<T> = Result<T, Box<EvalAltResult>>;

/// A value in few words, for errors.
pub(crate) fn shown(value: &Dynamic) -> String {
    let text = value.to_string();
    if text.chars().count() <= 40 { text } else { text.chars().take(40).collect::<String>() + "…" }
}

/// A number, whole or not.
pub(crate) fn number(value: &Dynamic) -> Option<f64> {
    value.as_float().ok().or_else(|| value.as_int().ok().map(|i| i as f64))
}

/// Three numbers of a list.
pub(crate) fn three(what: &str, value: &Dynamic) -> Result<[f64; 3], Box<EvalAltResult>> {
    let fault = || refuse(format!("{what} takes a list of three numbers, [x, y, z]; found {}", shown(value)));
    let Ok(list) = value.as_array_ref() else { return fault() };
    let mut out = [0.0; 3];
    if list.len() != 3 {
        return fault();
    }
    for (x, item) in out.iter_mut().zip(list.iter()) {
        match number(item) {
            Some(n) if n.is_finite() => *x = n,
            _ => return fault(),
        }
    }
    Ok(out)
}

/// A list of three numbers.
pub(crate) fn list(v: [f64; 3]) -> Dynamic {
    Dynamic::from_array(v.into_iter().map(Dynamic::from_float).collect())
}

/// A number that a program gives, finite.
pub(crate) fn finite(what: &str, value: &Dynamic) -> Answer<f64> {
    match number(value) {
        Some(x) if x.is_finite() => Ok(x),
        Some(x) => refuse(format!("{what} is {x}; allowed: a finite number")),
        None => refuse(format!("{what} takes a number; found {} ({})", shown(value), value.type_name())),
    }
}

/// A number within a range.
pub(crate) fn within(what: &str, value: &Dynamic, lo: f64, hi: f64) -> Answer<f64> {
    let x = finite(what, value)?;
    if x >= lo && x <= hi {
        return Ok(x);
    }
    let allowed = if hi == f64::MAX { format!("{lo} or more") } else { format!("{lo} to {hi}") };
    refuse(format!("{what} is {x}; allowed: {allowed}"))
}

/// Whether a DOF is measured in metres.
pub(crate) fn is_way(s: &Skeleton, dof: Dof) -> bool {
    match dof {
        Dof::Coordinate(..) => true,
        Dof::Axis(link) => matches!(s.links()[link].joint, Joint::Prismatic(_)),
        Dof::Rotation(_) => false,
    }
}

fn unit_fault<T>(s: &Skeleton, dof: Dof, what: &str) -> Answer<T> {
    let name = dof.name(s);
    let (kind, right) = match (is_way(s, dof), dof) {
        (true, _) => ("moves along a line", "m"),
        (false, Dof::Rotation(_)) => ("is a ball", "deg"),
        (false, _) => ("is a hinge", "deg"),
    };
    refuse(format!("`{what}`: {name} {kind}; allowed: the property that ends in `_{right}`"))
}

/// Degrees of a hinge or a ball.
pub(crate) fn deg(s: &Skeleton, dof: Dof, value: &Value, what: &str) -> Answer<Dynamic> {
    match value {
        _ if is_way(s, dof) => unit_fault(s, dof, what),
        Value::Scalar(x) => Ok(x.to_degrees().into()),
        Value::Rotation(r) => Ok(list(deg_from_quat(r))),
    }
}

/// The value of degrees; untouched to the bit where it is what it was.
pub(crate) fn from_deg(s: &Skeleton, dof: Dof, old: &Value, new: &Dynamic, what: &str) -> Answer<Value> {
    match old {
        _ if is_way(s, dof) => unit_fault(s, dof, what),
        Value::Scalar(x) => {
            let given = finite(what, new)?;
            Ok(if x.to_degrees() == given { *old } else { Value::Scalar(given.to_radians()) })
        }
        Value::Rotation(r) => {
            let given = three(what, new)?;
            Ok(if deg_from_quat(r) == given { *old } else { Value::Rotation(quat_from_deg(given)) })
        }
    }
}

/// Metres of a slide or a coordinate.
pub(crate) fn way(s: &Skeleton, dof: Dof, value: &Value, what: &str) -> Answer<f64> {
    match value {
        Value::Scalar(x) if is_way(s, dof) => Ok(*x),
        _ => unit_fault(s, dof, what),
    }
}

/// The value of metres.
pub(crate) fn from_way(s: &Skeleton, dof: Dof, new: &Dynamic, what: &str) -> Answer<Value> {
    if is_way(s, dof) { Ok(Value::Scalar(finite(what, new)?)) } else { unit_fault(s, dof, what) }
}

/// A turn that a program gives: a number for a hinge, `[x, y, z]` for a ball; rad, in `.x` for a hinge.
pub(crate) fn turn(s: &Skeleton, dof: Dof, by: &Dynamic, what: &str) -> Answer<Vec3> {
    match dof {
        _ if is_way(s, dof) => unit_fault(s, dof, what),
        Dof::Rotation(_) => Ok(Vec3::from(three(what, by)?.map(f64::to_radians))),
        _ => Ok(Vec3::x() * finite(what, by)?.to_radians()),
    }
}

/// A value turned on.
pub(crate) fn turned(value: &Value, by: &Vec3) -> Value {
    match value {
        Value::Scalar(x) => Value::Scalar(x + by.x),
        Value::Rotation(r) => Value::Rotation(exp(by) * r),
    }
}

/// The turn from one rotation to another in degrees: a list for a ball.
pub(crate) fn rotation_between(from: &Quat, to: &Quat) -> [f64; 3] {
    log(&(to * from.inverse())).map(f64::to_degrees).into()
}
