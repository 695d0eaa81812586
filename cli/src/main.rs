//! The `contrapposto` command: doors, no logic.
//!
//! In: a command line. Out: files, a summary on standard output, one block on standard error when
//! something is wrong; exit code 0, 1 (the run failed) or 2 (the input is bad).
//!
//! | module | holds |
//! |---|---|
//! | [`args`], [`analysis_args`], [`retarget_args`] | the command line |
//! | [`render`] | scene or clip to a folder of results |
//! | [`summary`] | what `render` says at the end |
//! | [`inspect`] | what is in a file |
//! | [`mod@plot`] | a trace or a clip to figures |
//! | [`analyze`] | a clip to the forces it needs |
//! | [`analysis_text`] | what `analyze` says at the end |
//! | [`engines`] | the engines to choose from |
//! | [`mod@crosscheck`] | forces against MuJoCo |
//! | [`push`], [`push_args`] | how hard a standing body can be pushed |
//! | [`tune`], [`tune_args`] | tension and balance chosen by a search |
//! | [`sweep`] | the same over a grid, in parts |
//! | [`mod@retarget`] | a human motion on a character |
//! | [`mod@propagate`], [`propagate_args`] | an edit learned from examples |
//! | [`pose`], [`pose_args`] | a pose of a clip corrected by dragging |
//! | [`mod@style`], [`style_args`] | style components of two motions, put into a third |
//! | [`convert`] | one format to another |
//! | [`library`] | names of the library; `library` and `new` |
//! | [`output`] | text on standard output |
//! | [`words`] | names of the libraries' enumerations as options |
//! | [`progress`] | the bar |
//! | [`failure`] | exit codes |

mod analysis_args;
mod analysis_text;
mod analyze;
mod args;
mod common_args;
mod convert;
mod crosscheck;
mod engines;
mod failure;
mod inspect;
mod library;
mod output;
mod pareto;
mod physics_args;
mod plot;
mod pose;
mod pose_args;
mod progress;
mod propagate;
mod propagate_args;
mod push;
mod push_args;
mod render;
mod retarget;
mod retarget_args;
mod style;
mod style_args;
mod summary;
mod sweep;
mod tune;
mod tune_args;
mod words;

use std::process::ExitCode;

use clap::Parser;

use crate::args::{Cli, Command};

fn main() -> ExitCode {
    if let Err(e) = takes::results::folder::interrupt::install() {
        // everything works without it, but Ctrl-C leaves temporary files behind
        let _ = std::io::Write::write_fmt(&mut std::io::stderr(), format_args!("warning: {e}\n"));
    }
    let mut command = Cli::parse().command;
    let done = library::resolve(&mut command).and_then(|()| match command {
        Command::Render(args) => render::run(&args),
        Command::Inspect(args) => inspect::run(&args),
        Command::Plot(args) => plot::run(&args),
        Command::Analyze(args) => analyze::run(&args),
        Command::Crosscheck(args) => crosscheck::run(&args),
        Command::Push(args) => push::run(&args),
        Command::Tune(args) => tune::run(&args),
        Command::Retarget(args) => retarget::run(&args),
        Command::Propagate(args) => propagate::run(&args),
        Command::Pose(args) => pose::run(&args),
        Command::Style(args) => style::run(&args),
        Command::Convert(args) => convert::run(&args),
        Command::Library(args) => library::run(&args),
        Command::New(args) => library::new(&args),
    });
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // nobody may be listening any more
            let _ = std::io::Write::write_fmt(&mut std::io::stderr(), format_args!("error: {failure}\n"));
            failure.code()
        }
    }
}
