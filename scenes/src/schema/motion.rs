//! Words of a motion that is not a script: a clip, or a human motion put on the character.

use retarget::{MappingModel, PipelineStage, RefineDofs, RefineDofsName, SizeRatio, SizeRatioName};
use serde::Deserialize;
use serde::de::VariantAccess;

use super::word::{Named, NamedWith, Variants};

/// Where a motion comes from that is not a script.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename = "motion")]
pub enum MotionRon {
    /// A clip (.bvh), relative to the scene file, performed by the character.
    Clip(String),
    /// A human motion put on the character.
    Retarget {
        /// The performance or clip, relative to the scene file.
        of: String,
        /// The key poses, relative to the scene file; by default those that lie beside the character.
        keyposes: Option<String>,
        /// The model.
        #[serde(default)]
        model: Named<MappingModel>,
        /// The last stage.
        #[serde(default)]
        stop_after: Named<PipelineStage>,
        /// How distances of travel scale.
        #[serde(default)]
        size: NamedWith<SizeRatio>,
        /// What the refinement may move.
        #[serde(default)]
        refine: NamedWith<RefineDofs>,
        /// Whether parts that can follow by dynamics do.
        #[serde(default = "yes")]
        sway: bool,
        /// Contact phases by hand, relative to the scene file.
        contacts: Option<String>,
    },
}

impl Variants for SizeRatio {
    type Name = SizeRatioName;

    fn variant<'de, A: VariantAccess<'de>>(name: SizeRatioName, data: A) -> Result<Self, A::Error> {
        match Self::named(name) {
            Some(ratio) => data.unit_variant().map(|()| ratio),
            None => data.newtype_variant().map(Self::Fixed),
        }
    }
}

impl Variants for RefineDofs {
    type Name = RefineDofsName;

    fn variant<'de, A: VariantAccess<'de>>(name: RefineDofsName, data: A) -> Result<Self, A::Error> {
        match Self::named(name) {
            Some(dofs) => data.unit_variant().map(|()| dofs),
            None => data.newtype_variant().map(Self::Links),
        }
    }
}

fn yes() -> bool {
    true
}
