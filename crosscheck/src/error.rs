//! Why nothing can be compared.

use formats::mjcf::MjcfError;
use formats::model::ImportError;
use sim::PassError;
use takes::TakeError;

use crate::bridge::BridgeError;
use crate::environment::EnvironmentError;
use crate::inject::InjectionError;
use crate::rigid::LARGEST;

/// Why nothing can be compared.
#[derive(Debug, thiserror::Error)]
pub enum CrossCheckError {
    /// A scene, clip or character file.
    #[error(transparent)]
    Take(#[from] TakeError),
    /// A model file.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// Something else than what can be compared.
    #[error(
        "{0}: cannot compare this; allowed: a scene or character (.ron), a clip (.bvh), a physics model (MJCF .xml, .urdf)"
    )]
    Kind(String),
    /// A push map of something that does not stand.
    #[error("{0}: a push map needs a scene (.ron) of a body that stands free")]
    NoScene(String),
    /// A fault that cannot be put in.
    #[error("--inject: {0}")]
    Inject(#[from] InjectionError),
    /// Two files of different kinds.
    #[error("--against {against}: {what} is compared with a file of its own kind")]
    Against {
        /// The other file.
        against: String,
        /// What is checked.
        what: &'static str,
    },
    /// More degrees of freedom than are compared.
    #[error(
        "the body has {0} degrees of freedom; at most {LARGEST} are compared: every state has a mass matrix"
    )]
    TooLarge(usize),
    /// A character that MJCF has no words for.
    #[error("no MJCF of this character: {0}")]
    Mjcf(#[from] MjcfError),
    /// No MuJoCo.
    #[error(transparent)]
    Environment(#[from] EnvironmentError),
    /// MuJoCo does not answer.
    #[error(transparent)]
    Bridge(#[from] BridgeError),
    /// A run that failed.
    #[error(transparent)]
    Pass(#[from] PassError),
    /// A body that cannot be pushed.
    #[error(transparent)]
    Push(studies::push::PushError),
    /// An engine that failed.
    #[error(transparent)]
    Engine(#[from] sim::EngineError),
}

impl CrossCheckError {
    /// Whether the input is at fault, not the run.
    pub fn is_input(&self) -> bool {
        if let Self::Push(e) = self {
            return e.is_input();
        }
        matches!(
            self,
            Self::Take(_)
                | Self::Import(_)
                | Self::Kind(_)
                | Self::NoScene(_)
                | Self::Inject(_)
                | Self::Against { .. }
                | Self::TooLarge(_)
                | Self::Mjcf(_)
                | Self::Bridge(BridgeError::Joints(_) | BridgeError::Bodies(_))
        )
    }
}
