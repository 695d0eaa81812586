//! Arguments: what a scene gives by name to a program of the user.

use std::fmt;

/// A value that a scene gives to a program.
#[derive(Clone, Debug, PartialEq)]
pub enum Argument {
    /// A number, whole or not.
    Number(f64),
    /// True or false.
    Flag(bool),
    /// A text.
    Text(String),
    /// A list of numbers.
    List(Vec<f64>),
    /// A list of texts.
    Texts(Vec<String>),
}

/// As a scene writes it.
impl fmt::Display for Argument {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(x) => write!(f, "{x}"),
            Self::Flag(b) => write!(f, "{b}"),
            Self::Text(text) => write!(f, "{text:?}"),
            Self::List(items) => write!(f, "{items:?}"),
            Self::Texts(items) => write!(f, "{items:?}"),
        }
    }
}
