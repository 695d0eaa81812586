//! The standard figure as a character file: `cargo run --release -p scenes --example make_human > scenes/characters/human.ron`.

fn main() {
    print!("{}", scenes::character_file::human_text());
}
