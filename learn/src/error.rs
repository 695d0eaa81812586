//! What can be wrong with the data a model is given, with the numbers that say so.

/// Which side of the pairs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// What a prediction starts from: the human.
    Input,
    /// What is predicted: the character.
    Output,
}

impl std::fmt::Display for Side {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Side::Input => "input",
            Side::Output => "output",
        })
    }
}

/// Why nothing can be learned from these pairs. Pairs are counted from 0.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitError {
    /// Whoever watched ended it.
    #[error("cancelled after {evaluations} evaluations of the likelihood")]
    Cancelled {
        /// How often the likelihood was evaluated.
        evaluations: usize,
    },
    /// Fewer pairs than the model needs.
    #[error("{found} pairs, at least {least} are needed")]
    TooFew {
        /// Pairs given.
        found: usize,
        /// Pairs needed.
        least: usize,
    },
    /// Inputs and outputs are not of one number.
    #[error("{inputs} inputs but {outputs} outputs: they come in pairs")]
    Unpaired {
        /// Rows of the inputs.
        inputs: usize,
        /// Rows of the outputs.
        outputs: usize,
    },
    /// Vectors without a coordinate.
    #[error("{side} vectors have no coordinates")]
    Empty {
        /// Which side.
        side: Side,
    },
    /// NaN or infinite.
    #[error("{side} {pair}, coordinate {coordinate} is {value}")]
    NotFinite {
        /// Which side.
        side: Side,
        /// Which pair.
        pair: usize,
        /// Which coordinate.
        coordinate: usize,
        /// What is there.
        value: f64,
    },
    /// All vectors of a side are the same.
    #[error("all {side} vectors are the same: nothing tells the pairs apart")]
    NoSpread {
        /// Which side.
        side: Side,
    },
    /// The same pair twice.
    #[error("pairs {first} and {second} are the same (inputs {input_distance:.2e} apart): keep one of them")]
    Duplicate {
        /// The earlier pair.
        first: usize,
        /// The later one.
        second: usize,
        /// Distance of their inputs in units of the inputs' RMS radius.
        input_distance: f64,
    },
    /// One input, two answers.
    #[error(
        "pairs {first} and {second} contradict each other: inputs {input_distance:.2e} apart, outputs {output_distance:.2} \
         (1 = the RMS distance of all from their mean)"
    )]
    Contradiction {
        /// The earlier pair.
        first: usize,
        /// The later one.
        second: usize,
        /// Distance of their inputs in units of the inputs' RMS radius.
        input_distance: f64,
        /// Distance of their outputs in units of the outputs' RMS radius.
        output_distance: f64,
    },
    /// A mirror for vectors of another length.
    #[error("mirror of {side} vectors has {found} coordinates, the vectors have {expected}")]
    MirrorLength {
        /// Which side.
        side: Side,
        /// Coordinates of the mirror.
        found: usize,
        /// Coordinates of the vectors.
        expected: usize,
    },
    /// A mirror that is no signed permutation which undoes itself.
    #[error(
        "mirror of {side} vectors: coordinate {coordinate} comes from {index} with sign {sign}; the sign must be 1 or -1, and \
         {index} must come from {coordinate} with the same sign"
    )]
    Mirror {
        /// Which side.
        side: Side,
        /// The coordinate.
        coordinate: usize,
        /// Where it comes from.
        index: usize,
        /// With which sign.
        sign: f64,
    },
    /// Not one moment for each example.
    #[error("{found} moments for {expected} examples")]
    Moments {
        /// Moments given.
        found: usize,
        /// Examples.
        expected: usize,
    },
    /// Examples to be added with another number of coordinates.
    #[error("{side} vectors to be added have {found} coordinates, the examples have {expected}")]
    Coordinates {
        /// Which side.
        side: Side,
        /// Coordinates given.
        found: usize,
        /// Coordinates of the examples.
        expected: usize,
    },
    /// Examples to be added that do not have what the others have.
    #[error("examples to be added have other {what}")]
    Unlike {
        /// What is not the same.
        what: &'static str,
    },
    /// A setting outside its range.
    #[error("{name} = {value}: must be {allowed}")]
    Setting {
        /// Which.
        name: &'static str,
        /// What was given.
        value: f64,
        /// What is allowed.
        allowed: String,
    },
    /// A stored model whose parts do not fit each other.
    #[error("stored model: {what}: {found}, expected {expected}")]
    Stored {
        /// Which part.
        what: &'static str,
        /// Its size.
        found: usize,
        /// The size the other parts ask for.
        expected: usize,
    },
    /// The optimiser gave up before its first step.
    #[error("learning stopped after {iterations} iterations: {reason}")]
    Optimiser {
        /// Steps taken.
        iterations: usize,
        /// The optimiser's words.
        reason: String,
    },
}

/// Why an input cannot be mapped.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum InputError {
    /// Another number of coordinates than the model was fitted to.
    #[error("input has {found} coordinates, the model was fitted to {expected}")]
    Dimension {
        /// Coordinates given.
        found: usize,
        /// Coordinates of the model.
        expected: usize,
    },
    /// NaN or infinite.
    #[error("input coordinate {coordinate} is {value}")]
    NotFinite {
        /// Which coordinate.
        coordinate: usize,
        /// What is there.
        value: f64,
    },
    /// A frame number beyond the frames given.
    #[error("frame {frame} of {frames}")]
    Frame {
        /// Asked for.
        frame: usize,
        /// Frames there are.
        frames: usize,
    },
}
