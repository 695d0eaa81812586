//! Models on disk, and data that is no good.

mod common {
    pub mod data;
}

use common::data::{curved, curved_pairs, path, uniform};
use learn::error::Side;
use learn::validate::ValidationError;
use learn::{
    FitError, GplvmOptions, InputError, KernelCca, Mapper, Method, Model, Nearest, Pairs, SharedGplvm,
    leave_out, map_frames,
};
use nalgebra::DMatrix;

/// Written and read back: the same model to the bit, and the same predictions.
#[test]
fn a_stored_model_is_the_model() {
    let frames = curved(&path(20)).0;
    for method in Method::ALL {
        let model = Model::fit(method, &curved_pairs(), &GplvmOptions::default()).unwrap();
        let text = ron::to_string(&model).unwrap();
        let back: Model = ron::from_str(&text).unwrap();
        assert_eq!(model, back, "{method}");
        assert_eq!(map_frames(&model, &frames).unwrap(), map_frames(&back, &frames).unwrap(), "{method}");
        assert_eq!(text, ron::to_string(&back).unwrap(), "{method}");
    }
}

/// A file someone edited: told, not crashed on.
#[test]
fn a_damaged_model_is_refused() {
    let model = SharedGplvm::fit(&curved_pairs(), &GplvmOptions::default()).unwrap();
    let text = ron::to_string(&model).unwrap();
    for (from, to, words) in [
        ("dimension:24", "dimension:25", "dimension = 25: must be from 1 to 24"),
        ("dimension:24", "dimension:23", "latent coordinates: 600, expected 575"),
        ("theta1:", "theta1:-", "not finite or positive: 1, expected 0"),
        ("latents:[", "latents:[NaN,", "latent coordinates: 601"),
        ("pairs:", "pears:", "pears"),
    ] {
        let damaged = text.replacen(from, to, 1);
        assert_ne!(damaged, text, "{from}");
        let error = ron::from_str::<SharedGplvm>(&damaged).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn names_are_those_of_the_command_line() {
    for method in Method::ALL {
        assert_eq!(method.name().parse(), Ok(method));
    }
    let error = "knn".parse::<Method>().unwrap_err().to_string();
    assert_eq!(error, "unknown model `knn`; known are gplvm, gp, pca, nn3, nn10");
}

#[test]
fn bad_pairs_are_told_with_their_numbers() {
    let (y, z) = curved(&uniform(12, 3, 9));
    let with = |m: &DMatrix<f64>, i: usize, k: usize, v: f64| {
        let mut m = m.clone();
        m[(i, k)] = v;
        m
    };
    let row = |m: &DMatrix<f64>, from: usize, to: usize, by: f64| {
        let mut m = m.clone();
        let r = m.row(from).add_scalar(by);
        m.set_row(to, &r);
        m
    };
    let refused = |y: &DMatrix<f64>, z: &DMatrix<f64>| Pairs::new(y, z).unwrap_err();
    assert_eq!(
        refused(&y, &z.rows(0, 11).into_owned()).to_string(),
        "12 inputs but 11 outputs: they come in pairs"
    );
    assert_eq!(
        refused(&y.rows(0, 1).into_owned(), &z.rows(0, 1).into_owned()),
        FitError::TooFew { found: 1, least: 2 }
    );
    assert_eq!(refused(&with(&y, 7, 2, f64::NAN), &z).to_string(), "input 7, coordinate 2 is NaN");
    let infinite = refused(&y, &with(&z, 3, 5, f64::INFINITY));
    assert_eq!(infinite.to_string(), "output 3, coordinate 5 is inf");
    assert_eq!(refused(&DMatrix::zeros(12, 0), &z), FitError::Empty { side: Side::Input });
    assert_eq!(refused(&y, &DMatrix::from_element(12, 2, 4.0)), FitError::NoSpread { side: Side::Output });
    let twice = refused(&row(&y, 2, 8, 0.0), &row(&z, 2, 8, 0.0));
    assert!(matches!(twice, FitError::Duplicate { first: 2, second: 8, .. }), "{twice}");
    // One input, two answers: found also when the inputs are only almost the same.
    for by in [0.0, 1e-3] {
        let error = refused(&row(&y, 2, 8, by), &z);
        assert!(matches!(error, FitError::Contradiction { first: 2, second: 8, .. }), "{error}");
        assert!(error.to_string().starts_with("pairs 2 and 8 contradict each other: inputs"), "{error}");
    }
    // Near inputs with near outputs are welcome.
    Pairs::new(&row(&y, 2, 8, 1e-3), &row(&z, 2, 8, 1e-3)).unwrap();
}

#[test]
fn bad_settings_are_told() {
    let pairs = curved_pairs();
    let few = pairs.subset(&[0, 1]).unwrap();
    let options = GplvmOptions::default();
    for (method, least) in [(Method::Gplvm, 3), (Method::Nn3, 3), (Method::Nn10, 10)] {
        let error = Model::fit(method, &few, &options).unwrap_err();
        assert_eq!(error, FitError::TooFew { found: 2, least });
    }
    Model::fit(Method::Gp, &few, &options).unwrap();
    Model::fit(Method::Pca, &few, &options).unwrap();
    let fit = |o: GplvmOptions| SharedGplvm::fit(&pairs, &o).unwrap_err().to_string();
    for q in [0, 25] {
        let words = fit(GplvmOptions { dimension: Some(q), ..options.clone() });
        assert_eq!(words, format!("dimension = {q}: must be from 1 to 24 (25 pairs)"));
    }
    for kappa in [0.0, -1.0, f64::NAN] {
        assert!(fit(GplvmOptions { kappa, ..options.clone() }).starts_with("kappa = "));
    }
    assert!(Nearest::fit(&pairs, 26).is_err() && Nearest::fit(&pairs, 0).is_err());
    assert!(pairs.subset(&[3, 25]).is_err());
    assert!(ron::from_str::<GplvmOptions>("(iteration: 3)").is_err());
}

#[test]
fn bad_inputs_are_told() {
    let model = Model::fit(Method::Gplvm, &curved_pairs(), &GplvmOptions::default()).unwrap();
    let mut mapper = Mapper::new(&model);
    let error = mapper.map(&[0.0; 8]).unwrap_err();
    assert_eq!(error, InputError::Dimension { found: 8, expected: 9 });
    let mut input = [0.0; 9];
    input[4] = f64::INFINITY;
    assert_eq!(mapper.map(&input).unwrap_err().to_string(), "input coordinate 4 is inf");
    let groups = [vec![0, 40]];
    let error = leave_out(&curved_pairs(), Method::Gp, &GplvmOptions::default(), &groups).unwrap_err();
    assert_eq!(error, ValidationError::Input(InputError::Frame { frame: 40, frames: 25 }));
}

/// Independent data must not come out correlated; without regularisation it does (the negative control), and
/// data with a common cause does with it.
#[test]
fn kernel_cca_does_not_find_what_is_not_there() {
    let (y, z) = (uniform(40, 6, 1), uniform(40, 5, 2));
    let independent = Pairs::new(&y, &z).unwrap();
    let first = |pairs: &Pairs, kappa: f64| KernelCca::fit(pairs, 5, kappa).unwrap().correlations[0];
    let (bare, regular) = (first(&independent, 1e-13), first(&independent, learn::kcca::KAPPA));
    let (y, z) = curved(&uniform(40, 3, 4));
    let related = first(&Pairs::new(&y, &z).unwrap(), learn::kcca::KAPPA);
    println!("independent: {regular:.3}, unregularised {bare:.6}; related: {related:.3}");
    assert!(bare > 0.999, "{bare}"); // 1.000 seen
    assert!(regular < 0.4, "{regular}"); // 0.28 seen
    assert!(related > 1.5 * regular, "{related} {regular}"); // 0.61 seen
}
