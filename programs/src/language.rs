//! The language of programs: rhai with what a program may use, and nothing else.
//!
//! Out: an [`Engine`] that knows numbers, texts, lists, maps and the functions of [`FUNCTIONS`]; [`crate::engine`] adds the values that an
//! edit or a reactive property hands out. Taken away are words that reach outside or make code from text (`eval`, `print`, `debug`,
//! `import`, `export`, `sleep`, `exit`), and `**`, whose last bit differs between machines: `pow` is the same everywhere.
//!
//! Limits are in [`crate::limits`]; the number of steps is given by the caller.

use rhai::packages::{
    ArithmeticPackage, BasicArrayPackage, BasicFnPackage, BasicIteratorPackage, BasicMapPackage,
    BasicStringPackage, LanguageCorePackage, LogicPackage, MoreStringPackage, Package,
};
use rhai::{Dynamic, Engine, EvalAltResult};

use crate::error::refuse;
use crate::limits::{CALL_LEVELS, ITEMS, NESTING, TEXT, VARIABLES};
use crate::noise::{noise, random};
use crate::values::{list, number, three};

/// Words that are refused.
const REFUSED: [&str; 7] = ["eval", "print", "debug", "import", "export", "**", "**="];

/// The functions that a program may call besides those of lists, maps and texts: name, and what it gives.
pub const FUNCTIONS: &[(&str, &str)] = &[
    ("sin(x), cos(x), tan(x)", "of an angle in radians"),
    ("sin_deg(x), cos_deg(x), tan_deg(x)", "of an angle in degrees"),
    ("asin(x), acos(x), atan(x), atan2(y, x)", "angle in radians"),
    ("degrees(x), radians(x)", "an angle in the other unit"),
    ("exp(x), ln(x), pow(x, y), sqrt(x), hypot(x, y)", "as their names say"),
    ("abs(x), sign(x), min(a, b), max(a, b), clamp(x, lo, hi)", "whole numbers stay whole"),
    ("floor(x), ceil(x), round(x)", "a number without fraction"),
    ("to_int(x), to_float(x)", "the same number as a whole one, or with a fraction"),
    ("lerp(a, b, u)", "a + (b − a) u"),
    ("smoothstep(a, b, x)", "0 below a, 1 above b, 3u² − 2u³ between"),
    ("noise(seed, t)", "smooth noise in [−1, 1], a new value every unit of t"),
    ("random(seed, n)", "the n-th number of a stream, in [0, 1)"),
    ("length(v), dot(a, b), cross(a, b)", "of lists of three numbers"),
    ("PI()", "half a turn in radians"),
];

/// The engine of the language alone, stopping programs after `steps` steps.
pub fn language(steps: u64) -> Engine {
    let mut e = Engine::new_raw();
    e.register_global_module(LanguageCorePackage::new().as_shared_module());
    e.register_global_module(ArithmeticPackage::new().as_shared_module());
    e.register_global_module(LogicPackage::new().as_shared_module());
    e.register_global_module(BasicIteratorPackage::new().as_shared_module());
    e.register_global_module(BasicFnPackage::new().as_shared_module());
    e.register_global_module(BasicStringPackage::new().as_shared_module());
    e.register_global_module(MoreStringPackage::new().as_shared_module());
    e.register_global_module(BasicArrayPackage::new().as_shared_module());
    e.register_global_module(BasicMapPackage::new().as_shared_module());
    for word in REFUSED {
        e.disable_symbol(word);
    }
    e.set_max_operations(steps)
        .set_max_call_levels(CALL_LEVELS)
        .set_max_expr_depths(NESTING, NESTING)
        .set_max_string_size(TEXT)
        .set_max_array_size(ITEMS)
        .set_max_map_size(ITEMS)
        .set_max_variables(VARIABLES)
        .set_strict_variables(true)
        .set_fail_on_invalid_map_property(true);
    refusals(&mut e);
    mathematics(&mut e);
    e
}

/// A function of one number, whole or not.
fn one(e: &mut Engine, name: &str, f: fn(f64) -> f64) {
    e.register_fn(name, f);
    e.register_fn(name, move |x: i64| f(x as f64));
}

/// A function of two numbers, whole or not.
fn two(e: &mut Engine, name: &str, f: fn(f64, f64) -> f64) {
    e.register_fn(name, f);
    e.register_fn(name, move |x: i64, y: i64| f(x as f64, y as f64));
    e.register_fn(name, move |x: i64, y: f64| f(x as f64, y));
    e.register_fn(name, move |x: f64, y: i64| f(x, y as f64));
}

/// A function of three numbers, whole or not.
fn three_of(e: &mut Engine, name: &'static str, f: fn(f64, f64, f64) -> f64) {
    e.register_fn(name, f);
    let any = move |a: Dynamic, b: Dynamic, c: Dynamic| match (number(&a), number(&b), number(&c)) {
        (Some(a), Some(b), Some(c)) => Ok(f(a, b, c)),
        _ => refuse(format!("{name} takes three numbers")),
    };
    e.register_fn(name, any);
}

fn smoothstep(a: f64, b: f64, x: f64) -> f64 {
    if a == b {
        return if x < a { 0.0 } else { 1.0 };
    }
    let u = ((x - a) / (b - a)).clamp(0.0, 1.0);
    u * u * (3.0 - 2.0 * u)
}

/// Radians of degrees.
fn rad(x: f64) -> f64 {
    x.to_radians()
}

/// Functions of the language that wait or end the program, replaced by ones that refuse.
fn refusals(e: &mut Engine) {
    fn no(name: &str) -> Result<(), Box<EvalAltResult>> {
        refuse(format!("a program cannot `{name}`"))
    }
    e.register_fn("sleep", |_: i64| no("sleep"));
    e.register_fn("sleep", |_: f64| no("sleep"));
    e.register_fn("exit", || no("exit"));
    e.register_fn("exit", |_: Dynamic| no("exit"));
}

fn mathematics(e: &mut Engine) {
    for (name, f) in [
        ("sin", libm::sin as fn(f64) -> f64),
        ("cos", libm::cos),
        ("tan", libm::tan),
        ("asin", libm::asin),
        ("acos", libm::acos),
        ("atan", libm::atan),
        ("exp", libm::exp),
        ("ln", libm::log),
        ("sqrt", libm::sqrt),
        ("floor", libm::floor),
        ("ceil", libm::ceil),
        ("round", libm::round),
        ("sin_deg", |x| libm::sin(rad(x))),
        ("cos_deg", |x| libm::cos(rad(x))),
        ("tan_deg", |x| libm::tan(rad(x))),
        ("degrees", f64::to_degrees),
        ("radians", f64::to_radians),
        ("to_float", |x| x),
    ] {
        one(e, name, f);
    }
    two(e, "atan2", libm::atan2);
    two(e, "pow", libm::pow);
    two(e, "hypot", libm::hypot);
    two(e, "min", f64::min);
    two(e, "max", f64::max);
    // whole numbers stay whole; what is registered last holds
    e.register_fn("min", |a: i64, b: i64| a.min(b));
    e.register_fn("max", |a: i64, b: i64| a.max(b));
    e.register_fn("to_int", |x: i64| x);
    e.register_fn("to_int", |x: f64| {
        if x.abs() < 9.0e15 { Ok(x as i64) } else { refuse(format!("to_int: {x} has no whole number")) }
    });
    three_of(e, "clamp", |x, lo, hi| x.max(lo).min(hi));
    three_of(e, "lerp", |a, b, u| a + (b - a) * u);
    three_of(e, "smoothstep", smoothstep);
    e.register_fn("noise", noise);
    e.register_fn("noise", |seed: i64, t: i64| noise(seed, t as f64));
    e.register_fn("random", random);
    e.register_fn("PI", || std::f64::consts::PI);
    e.register_fn("length", |v: Dynamic| {
        let [x, y, z] = three("length", &v)?;
        Ok::<_, Box<EvalAltResult>>(libm::sqrt(x * x + y * y + z * z))
    });
    e.register_fn("dot", |a: Dynamic, b: Dynamic| {
        let (a, b) = (three("dot", &a)?, three("dot", &b)?);
        Ok::<_, Box<EvalAltResult>>(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])
    });
    e.register_fn("cross", |a: Dynamic, b: Dynamic| {
        let ([ax, ay, az], [bx, by, bz]) = (three("cross", &a)?, three("cross", &b)?);
        Ok::<_, Box<EvalAltResult>>(list([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]))
    });
}
