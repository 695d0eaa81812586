//! A frame mapped costs no allocation, with any model.

mod common {
    pub mod data;
}

use common::data::{curved, curved_pairs, path};
use learn::{GplvmOptions, Mapper, Method, Model};

#[test]
fn mapping_does_not_allocate() {
    let frames = curved(&path(30)).0.transpose();
    for method in Method::ALL {
        let model = Model::fit(method, &curved_pairs(), &GplvmOptions::default()).unwrap();
        let mut mapper = Mapper::new(&model);
        mapper.map(&frames.as_slice()[..9]).unwrap();
        let counted = allocation_counter::measure(|| {
            for frame in frames.as_slice().chunks_exact(9) {
                mapper.map(frame).unwrap();
            }
        });
        assert_eq!(counted.count_total, 0, "{method}");
    }
}
