use std::path::Path;
fn main() {
    for a in std::env::args().skip(1) {
        let stage = match scenes::open(Path::new(&a), None, &Default::default()) {
            Ok(s) => s,
            Err(e) => {
                eprintln!("{e}");
                continue;
            }
        };
        let out = stage.perform(&mut |_| {}).unwrap();
        println!("{}", scenes::Report::new(&stage, Some(&out)).to_json());
    }
}
