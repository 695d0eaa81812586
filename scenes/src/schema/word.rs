//! Names of values in a RON text, read by the table of their enumeration.
//!
//! In: a variant, such as `RootHeight` or `Bezier(0.2, 0, 0.4, 1)`. Out: the value whose name ([`motion::names::Word`]) that is.
//! Capitals and underscores make no difference, so `Gplvm` and `gplvm` are the same. A name that is none is an error at its line
//! and column, with the nearest name as scenes write it.
//!
//! An enumeration without data is read as [`Named`]. One whose values carry data is read as [`NamedWith`] and says
//! in [`Variants`] what follows each name.

use std::fmt;
use std::marker::PhantomData;

use motion::names::{Word, nearest};
use serde::Deserialize;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{
    self, DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, MapAccess, SeqAccess, VariantAccess,
    Visitor,
};

/// A value without data, read by its name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Named<W>(pub W);

/// A value some of whose kind carry data, read by its name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NamedWith<T>(pub T);

/// An enumeration some of whose values carry data.
pub trait Variants: Sized {
    /// The names of its values.
    type Name: Word;

    /// The value of a name with the data that follow it.
    fn variant<'de, A: VariantAccess<'de>>(name: Self::Name, data: A) -> Result<Self, A::Error>;
}

impl<'de, W: Word> Deserialize<'de> for Named<W> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        d.deserialize_enum(W::KIND, &[], Variant::<W, Self>(PhantomData))
    }
}

impl<'de, T: Variants> Deserialize<'de> for NamedWith<T> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        d.deserialize_enum(T::Name::KIND, &[], Variant::<T::Name, Self>(PhantomData))
    }
}

/// What follows the name of a value that is read as a `Self`.
trait AfterName<W>: Sized {
    fn after<'de, A: VariantAccess<'de>>(name: W, data: A) -> Result<Self, A::Error>;
}

impl<W: Word> AfterName<W> for Named<W> {
    fn after<'de, A: VariantAccess<'de>>(name: W, data: A) -> Result<Self, A::Error> {
        data.unit_variant().map(|()| Self(name))
    }
}

impl<T: Variants> AfterName<T::Name> for NamedWith<T> {
    fn after<'de, A: VariantAccess<'de>>(name: T::Name, data: A) -> Result<Self, A::Error> {
        T::variant(name, data).map(Self)
    }
}

/// Reads a name and what follows it.
struct Variant<W, T>(PhantomData<(W, T)>);

impl<'de, W: Word, T: AfterName<W>> Visitor<'de> for Variant<W, T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a {}: {}", W::KIND, known::<W>())
    }

    fn visit_enum<A: EnumAccess<'de>>(self, access: A) -> Result<T, A::Error> {
        let (name, data) = access.variant_seed(Name(PhantomData))?;
        T::after(name, data)
    }
}

/// The data of a variant with named fields: `Assisted(force_n: 80, moment_nm: 20)`.
pub(super) fn fields<'de, T: DeserializeOwned, A: VariantAccess<'de>>(data: A) -> Result<T, A::Error> {
    data.struct_variant(&[], Data(PhantomData))
}

/// The data of a variant with `n` numbers: `Bezier(0.2, 0, 0.4, 1)`.
pub(super) fn numbers<'de, T: DeserializeOwned, A: VariantAccess<'de>>(
    data: A,
    n: usize,
) -> Result<T, A::Error> {
    data.tuple_variant(n, Data(PhantomData))
}

/// Hands fields or numbers to the type that they make.
struct Data<T>(PhantomData<T>);

impl<'de, T: DeserializeOwned> Visitor<'de> for Data<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the data of a variant")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        T::deserialize(MapAccessDeserializer::new(map))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<T, A::Error> {
        T::deserialize(SeqAccessDeserializer::new(seq))
    }
}

/// A name, looked up in its table.
struct Name<W>(PhantomData<W>);

impl<'de, W: Word> DeserializeSeed<'de> for Name<W> {
    type Value = W;

    fn deserialize<D: Deserializer<'de>>(self, d: D) -> Result<W, D::Error> {
        d.deserialize_identifier(self)
    }
}

impl<W: Word> Visitor<'_> for Name<W> {
    type Value = W;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a {}: {}", W::KIND, known::<W>())
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<W, E> {
        W::find(text).map_err(|e| {
            let names: Vec<String> = W::WORDS.iter().map(|w| w.0.identifier()).collect();
            let hint = match nearest(text, names.iter().map(String::as_str)) {
                Some(name) => format!("did you mean `{name}`?"),
                None => format!("known are {}", known::<W>()),
            };
            E::custom(format!("unknown {} `{}`; {hint}", e.kind, e.found))
        })
    }
}

/// All names as scenes write them.
fn known<W: Word>() -> String {
    let names: Vec<String> = W::WORDS.iter().map(|w| format!("`{}`", w.0.identifier())).collect();
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Source;
    use crate::schema::{AssistRon, GroundRon, MotionRon, RootRon};
    use motion::Curve;
    use retarget::{MappingModel, SizeRatio};

    fn fault<T: DeserializeOwned + fmt::Debug>(text: &str) -> String {
        Source::new("a.ron", text).parse::<T>().unwrap_err().to_string()
    }

    fn value<T: DeserializeOwned>(text: &str) -> T {
        Source::new("a.ron", text).parse().unwrap_or_else(|e| panic!("{text}: {e}"))
    }

    #[test]
    fn names_are_read_whatever_their_case() {
        for text in ["Nn10", "nn10", " NN_10 "] {
            assert_eq!(value::<Named<MappingModel>>(text).0, MappingModel::Nn10, "{text}");
        }
        assert_eq!(value::<NamedWith<Curve>>("ease_in_out").0, Curve::EaseInOut);
        let bezier = Curve::Bezier(0.2, 0.0, 0.4, 1.0);
        assert_eq!(value::<NamedWith<Curve>>("Bezier(0.2, 0, 0.4, 1)").0, bezier);
        assert_eq!(value::<NamedWith<SizeRatio>>("paper").0, SizeRatio::PerAxis);
        assert_eq!(value::<NamedWith<SizeRatio>>("Fixed(0.3)").0, SizeRatio::Fixed(0.3));
        let RootRon::Assisted(AssistRon { force_n, moment_nm }) =
            value::<NamedWith<RootRon>>("assisted(moment_nm: 2, force_n: 1)").0
        else {
            panic!("not assisted");
        };
        assert_eq!([force_n, moment_nm], [1.0, 2.0]);
    }

    /// The place is that of the name, as of every other unknown name.
    #[test]
    fn an_unknown_name_is_answered_at_its_place_with_the_nearest() {
        let e = fault::<MotionRon>("Retarget(\n    of: \"a.ron\",\n    model: Glvm,\n)");
        assert_eq!(e, "unknown model `Glvm`; did you mean `Gplvm`?\n  --> a.ron:3:12");
        let e = fault::<MotionRon>("Retarget(of: \"a.ron\", stop_after: nowhere)");
        assert_eq!(
            e,
            "unknown stage `nowhere`; known are `Map`, `Global`, `Contact`, `Refine`\n  --> a.ron:1:35"
        );
        assert!(
            fault::<NamedWith<Curve>>("EaseInOt")
                .starts_with("unknown curve `EaseInOt`; did you mean `EaseInOut`?")
        );
    }

    /// What follows a name is checked as everywhere: fields by name, numbers by count.
    #[test]
    fn data_that_do_not_fit_are_refused() {
        let e = fault::<NamedWith<GroundRon>>("Plane(friction: 0.8, heigt_m: 1)");
        assert!(
            e.contains("unknown field `heigt_m` of `Plane`; did you mean `height_m`?")
                && e.contains("a.ron:1:22"),
            "{e}"
        );
        let e = fault::<NamedWith<RootRon>>("Assisted(force_n: 1)");
        assert!(e.contains("missing field named `moment_nm` in `Assisted`"), "{e}");
        assert!(fault::<NamedWith<Curve>>("Bezier(1, 2, 3)").contains("a.ron:1:"));
        assert!(fault::<NamedWith<RootRon>>("Free(1)").contains("a.ron:1:"));
        assert!(fault::<NamedWith<SizeRatio>>("Fixed").contains("a.ron:1:"));
    }
}
