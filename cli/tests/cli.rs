//! The command from outside: exit codes, messages, files.

#[path = "cli/analyze.rs"]
mod analyze;
#[path = "cli/bad_input.rs"]
mod bad_input;
#[path = "cli/convert.rs"]
mod convert;
#[path = "cli/crosscheck.rs"]
mod crosscheck;
#[path = "cli/inspect.rs"]
mod inspect;
#[path = "cli/interrupt.rs"]
mod interrupt;
#[path = "cli/library.rs"]
mod library;
#[path = "cli/output.rs"]
mod output;
#[path = "cli/place.rs"]
mod place;
#[path = "cli/plot.rs"]
mod plot;
#[path = "cli/pose.rs"]
mod pose;
#[path = "cli/propagate.rs"]
mod propagate;
#[path = "cli/propagate_loop.rs"]
mod propagate_loop;
#[path = "cli/push.rs"]
mod push;
#[path = "cli/references.rs"]
mod references;
#[path = "cli/render.rs"]
mod render;
#[path = "cli/report.rs"]
mod report;
#[path = "cli/retarget.rs"]
mod retarget;
#[path = "cli/style.rs"]
mod style;
#[path = "cli/tune.rs"]
mod tune;
