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
//! | [`figures`] | which figures a run gets |
//! | [`inspect`] | what is in a file |
//! | [`mod@plot`] | a trace or a clip to figures |
//! | [`analyze`] | a clip to the forces it needs |
//! | [`analysis_text`] | what `analyze` says at the end |
//! | [`drawing`] | the figures of `plot` and `analyze` |
//! | [`mod@crosscheck`] | forces against MuJoCo |
//! | [`push`] | how hard a standing body can be pushed |
//! | [`tune`], [`tune_args`], [`tune_page`] | tension and balance chosen by a search |
//! | [`sweep`] | the same over a grid, in parts |
//! | [`mod@retarget`] | a human motion on a character |
//! | [`retarget_figures`] | which figures that gets |
//! | [`convert`] | one format to another |
//! | [`output`] | all files or none |
//! | [`progress`] | the bar |
//! | [`failure`] | exit codes |

mod analysis_args;
mod analysis_text;
mod analyze;
mod args;
mod convert;
mod crosscheck;
mod drawing;
mod failure;
mod figures;
mod inspect;
mod output;
mod pareto;
mod plot;
mod progress;
mod push;
mod render;
mod retarget;
mod retarget_args;
mod retarget_figures;
mod summary;
mod sweep;
mod tune;
mod tune_args;
mod tune_page;

use std::process::ExitCode;

use clap::Parser;

use crate::args::{Cli, Command};

fn main() -> ExitCode {
    let done = match Cli::parse().command {
        Command::Render(args) => render::run(&args),
        Command::Inspect(args) => inspect::run(&args),
        Command::Plot(args) => plot::run(&args),
        Command::Analyze(args) => analyze::run(&args),
        Command::Crosscheck(args) => crosscheck::run(&args),
        Command::Push(args) => push::run(&args),
        Command::Tune(args) => tune::run(&args),
        Command::Retarget(args) => retarget::run(&args),
        Command::Convert(args) => convert::run(&args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // nobody may be listening any more
            let _ = std::io::Write::write_fmt(&mut std::io::stderr(), format_args!("error: {failure}\n"));
            failure.code()
        }
    }
}
