//! `style`: components of two motions, and motions with style.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use takes::styles::style::{On, StyleSet, Transfer};
use takes::styles::{self, Find, library, results};
use takes::{Ask, Take, What};

use crate::args::StyleArgs;
use crate::failure::Failure;
use crate::output;
use crate::progress::progress;
use crate::style_args::{
    BlendArgs, DecomposeArgs, FindArgs, PutArgs, StyleCommand, TransferArgs, TryArgs, ships,
};

/// Runs the command.
///
/// # Errors
/// Bad input, motions that cannot be decomposed, files that cannot be written.
pub fn run(args: &StyleArgs) -> Result<(), Failure> {
    match &args.command {
        StyleCommand::Decompose(args) => decompose(args),
        StyleCommand::Transfer(args) => transfer(args),
        StyleCommand::Blend(args) => blend(args),
        StyleCommand::Try(args) => try_all(args),
    }
}

fn open(path: &Path) -> Result<Take, Failure> {
    Ok(takes::open(path, &Ask::default())?)
}

fn find(args: &FindArgs) -> Find {
    Find {
        count: args.count.map(usize::from),
        variance: args.variance / 100.0,
        representation: args.representation,
        merge: args.merge.clone(),
        names: args.names.iter().cloned().collect(),
    }
}

/// What is said of a set: every component in words, then the notes.
fn said(set: &StyleSet) -> String {
    let mut text = format!(
        "{} and {}: {} components, {:.1} % of the variance; {} steps, {} of {} starts came to rest\n\n",
        set.names[0],
        set.names[1],
        set.components(),
        100.0 * set.explained,
        set.trust.steps,
        set.trust.converged_starts.0,
        set.trust.converged_starts.1
    );
    for c in 0..set.components() {
        text += &format!("  {}: {}\n", c + 1, set.words(c));
    }
    for note in &set.notes {
        text += &format!("  note: {note}\n");
    }
    text
}

fn decompose(args: &DecomposeArgs) -> Result<(), Failure> {
    let progress = progress();
    progress.part("decomposing");
    let (a, b) = (open(&args.a)?, open(&args.b)?);
    let find = find(&args.find);
    let set = find.set(&a, &b, false)?;
    let principal =
        Find { merge: Vec::new(), count: Some(set.activations.ncols()), ..find }.set(&a, &b, true)?;
    let dir = output::folder(args.out.as_deref(), &format!("{}-{}-style", a.name, b.name));
    let reads: Vec<PathBuf> = a.files.iter().chain(&b.files).cloned().collect();
    let file = results::write(&dir, &a, &set, &principal, &reads)?;
    drop(progress);
    output::print(&format!(
        "{}\nwrote {} and {}/plots: components, principal, activations\n",
        said(&set),
        file.display(),
        dir.display()
    ))
}

/// The set, the number of the donor in it, and its name: a file, or the two motions taken apart.
fn set_for(
    from: &Path,
    to: &Take,
    args: &FindArgs,
) -> Result<(Arc<StyleSet>, String, Vec<PathBuf>), Failure> {
    let named = ships(from);
    if named || formats::format_of(from).is_some_and(|f| f.endings == ["style"]) {
        let set = styles::open(from)?;
        let name = set.names[1].clone();
        return Ok((Arc::new(set), name, if named { Vec::new() } else { vec![from.to_owned()] }));
    }
    let donor = open(from)?;
    let set = find(args).set(to, &donor, false)?;
    Ok((Arc::new(set), donor.name.clone(), donor.files))
}

/// What a motion calls the bones of a set: as the user says, and what its own links are for.
fn names(to: &Take, args: &FindArgs) -> BTreeMap<String, String> {
    let mut all = library::names_for(&to.body.character);
    all.extend(args.names.iter().cloned());
    all
}

fn how(set: &StyleSet, args: &PutArgs, amount: f64, ships: bool) -> Result<Transfer, Failure> {
    let mut how = Transfer::of(set, 1, amount);
    if ships {
        how = how.only(&library::components(set), amount);
    }
    if !args.components.is_empty() {
        let components = set.numbered(&args.components).map_err(Failure::input)?;
        how = how.only(&components, amount);
    }
    if let Some(bone) = &args.align {
        how.on = On::Bone(bone.clone());
    }
    if !args.anchors.is_empty() {
        how.on = On::Anchors(args.anchors.clone());
    }
    how.timing = args.timing;
    Ok(how)
}

fn transfer(args: &TransferArgs) -> Result<(), Failure> {
    let progress = progress();
    progress.part("transferring");
    let to = open(&args.to)?;
    let (set, donor, reads) = set_for(&args.from, &to, &args.find)?;
    let how = how(&set, &args.put, args.amount, ships(&args.from))?;
    let names = names(&to, &args.find);
    let mut styled = styles::styled(&to, &set, &how, &names)?;
    styled.name = format!("{}-like-{donor}", to.name);
    let dir = output::folder(args.out.as_deref(), &styled.name);
    let what = What { figures: !args.no_plots, reads };
    styled.check(&dir, &what, true)?;
    let numbers: Vec<String> = how.components.iter().map(|c| (c.0 + 1).to_string()).collect();
    let log = styled.log.to_string();
    let written = styled.preview().write(&dir, &what, &progress)?;
    drop(progress);
    output::print(&format!(
        "{}\ncomponents {} of {donor} by {} in {}:\n{log}\nwrote {}\n",
        said(&set),
        numbers.join(", "),
        args.amount,
        to.name,
        dir.display()
    ))?;
    output::undrawn(&written.undrawn, &dir)
}

fn blend(args: &BlendArgs) -> Result<(), Failure> {
    let progress = progress();
    progress.part("blending");
    let to = open(&args.to)?;
    let (set, donor, mut reads) = set_for(&args.from, &to, &args.find)?;
    reads.extend(to.files.iter().cloned());
    let names = names(&to, &args.find);
    let rows = args
        .amounts
        .iter()
        .map(|amount| {
            let take = styles::styled(&to, &set, &how(&set, &args.put, *amount, ships(&args.from))?, &names)?;
            Ok((format!("{:.0} % of {donor}", 100.0 * amount), take))
        })
        .collect::<Result<Vec<_>, Failure>>()?;
    let dir = output::folder(args.out.as_deref(), &format!("{}-to-{donor}", to.name));
    let title = format!("{}, more and more like {donor}", to.name);
    let files = results::write_rows(&dir, &rows, &title, "continuum", &reads)?;
    drop(progress);
    output::print(&format!("{}\nwrote {}: {}\n", said(&set), dir.display(), files.join(", ")))
}

fn try_all(args: &TryArgs) -> Result<(), Failure> {
    let progress = progress();
    progress.part("trying");
    let take = open(&args.input)?;
    let mut rows = vec![(format!("{}, as it is", take.name), take.clone())];
    let all: Vec<PathBuf> = match &args.styles[..] {
        [] => library::SHIPPED.iter().map(|style| PathBuf::from(style.name)).collect(),
        named => named.to_vec(),
    };
    let names = library::names_for(&take.body.character);
    for path in &all {
        let set = Arc::new(styles::open(path)?);
        let styled = styles::styled(&take, &set, &how(&set, &args.put, args.amount, ships(path))?, &names)?;
        let label = match path.exists() {
            true => format!("{} of {}", set.names[1], path.display()),
            false => path.display().to_string(),
        };
        rows.push((label, styled));
    }
    let dir = output::folder(args.out.as_deref(), &format!("{}-styles", take.name));
    let reads: Vec<PathBuf> =
        take.files.iter().chain(all.iter().filter(|path| path.exists())).cloned().collect();
    let title = format!("{} with every style", take.name);
    let files = results::write_rows(&dir, &rows, &title, "styles", &reads)?;
    drop(progress);
    output::print(&format!("wrote {}: {}\n", dir.display(), files.join(", ")))
}
