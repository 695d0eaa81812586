//! The algorithms of `dynamics` reuse their memory: nothing is allocated per call.
//!
//! A binary of its own, because the counting allocator is global.

use allocation_counter::measure;
use bodies::anthropometry::human::human;
use dynamics::penalty::{Penalty, contact_forces};
use dynamics::{ForwardDynamics, InverseDerivatives, Model, State, Wrench};
use motion::Vec3;
use nalgebra::DMatrix;

#[test]
fn nothing_is_allocated_per_call() {
    let (character, _) = human();
    let model = Model::new(&character, Vec3::new(0.0, -9.81, 0.0));
    let n = model.nv();
    let mut state = State::new(&model);
    let mut forward = ForwardDynamics::new(&model);
    let mut slopes = InverseDerivatives::new(&model);
    let q = character.rest.clone();
    let v: Vec<f64> = (0..n).map(|k| (k as f64).sin()).collect();
    let (mut tau, mut vd) = (vec![0.0; n], vec![0.0; n]);
    let mut m = DMatrix::zeros(n, n);
    let penalty = Penalty::for_body(model.mass, 9.81, character.contacts.len(), 0.0015).unwrap();
    let mut wrenches: Vec<Wrench> = Vec::with_capacity(character.contacts.len());
    let mut out = Vec3::zeros();
    let count = measure(|| {
        state.update(&model, &q, &v);
        contact_forces(&penalty, &model, &state, &character.contacts, 0.01, &[], &mut wrenches);
        state.inverse_dynamics(&model, &v, &v, &wrenches, &mut tau);
        state.bias(&model, &v, &mut tau);
        state.coriolis(&model, &v, &mut tau);
        state.gravity_load(&model, &mut tau);
        state.mass_matrix(&model, &mut m);
        state.gravity_stiffness(&model, &mut m);
        state.inboard_inertia(&model, &mut tau);
        state.add_wrench(&model, &wrenches[0], &mut tau);
        forward.accelerations(&model, &mut state, &v, &tau, &wrenches, &mut vd).unwrap();
        slopes.update(&model, &state, &v, &vd, &wrenches);
        out += state.com(&model) + state.momentum(&model).angular;
        out += state.momentum_rate(&model, &v, &vd).linear;
        out.x += state.energy(&model).0;
    });
    assert_eq!((count.count_total, count.bytes_total), (0, 0));
    assert!(out.norm() > 0.0);
    // the counter counts
    assert_eq!(measure(|| drop(std::hint::black_box(vec![0.0; n]))).count_total, 1);
}
