//! Makes the styles that ship: `cargo run --release -p takes --example make_styles`.
//!
//! Writes `takes/styles/NAME.style` and the contact sheets `docs/images/style-NAME.png` of all of them, from the performances of the
//! library. The names are those of `takes::styles::library::SHIPPED`; for a new one begin with an empty file.

use std::error::Error;
use std::path::Path;

use formats::style_file;
use takes::styles::figures::contact_sheet;
use takes::styles::library::SHIPPED;
use takes::styles::made::made;

/// Height of a figure in the pictures, pixels.
const BODY_HEIGHT: f64 = 120.0;

fn main() -> Result<(), Box<dyn Error>> {
    let home = Path::new(env!("CARGO_MANIFEST_DIR"));
    for style in &SHIPPED {
        let (take, set) = made(style.name)?;
        std::fs::write(home.join("styles").join(format!("{}.style", style.name)), style_file::bytes(&set))?;
        let picture = home.join("../docs/images").join(format!("style-{}.png", style.name));
        let title = format!("What makes a walk {}", style.name);
        contact_sheet(&take, &set, &title, BODY_HEIGHT).save_png(&picture)?;
        println!("{}: {} components", style.name, set.components());
        for c in 0..set.components() {
            println!("  {}: {}", c + 1, set.words(c));
        }
        set.notes.iter().for_each(|note| println!("  note: {note}"));
    }
    Ok(())
}
