//! Words of the libraries on the command line: an enumeration with names is an option's values, each with its line of help.

use clap::builder::{PossibleValue, TypedValueParser};
use motion::names::Word;

/// A parser of the words of `W`.
pub fn word<W: Word + Send + Sync>() -> WordParser<W> {
    WordParser(std::marker::PhantomData)
}

/// Takes the names of an enumeration, whatever their case.
#[derive(Debug)]
pub struct WordParser<W>(std::marker::PhantomData<fn() -> W>);

impl<W> Clone for WordParser<W> {
    fn clone(&self) -> Self {
        Self(std::marker::PhantomData)
    }
}

impl<W: Word + Send + Sync> TypedValueParser for WordParser<W> {
    type Value = W;

    fn parse_ref(
        &self,
        command: &clap::Command,
        arg: Option<&clap::Arg>,
        value: &std::ffi::OsStr,
    ) -> Result<W, clap::Error> {
        let fault = |text: String| {
            let name = arg.map_or_else(|| "argument".to_owned(), ToString::to_string);
            let text = format!("invalid value for '{name}': {text}");
            clap::Error::raw(clap::error::ErrorKind::InvalidValue, text + "\n").with_cmd(command)
        };
        let text = value.to_str().ok_or_else(|| fault("not UTF-8".into()))?;
        W::find(text).map_err(|e| fault(e.to_string()))
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(W::WORDS.iter().map(|w| PossibleValue::new(w.1).help(w.2))))
    }
}

#[cfg(test)]
mod tests {
    use crate::args::{Cli, Command};
    use clap::{CommandFactory, Parser};
    use formats::bvh::Axis;
    use motion::names::Word;
    use studies::tune::{SearchStart, SolverKind};
    use takes::overrides::{RootChoice, RootName, Strategy};
    use takes::retarget::{MappingModel, PipelineStage, RefineDofs, SizeRatio, SizeRatioName};

    fn parse(line: &str) -> Result<Command, String> {
        let words = std::iter::once("contrapposto").chain(line.split(' '));
        Cli::try_parse_from(words).map(|cli| cli.command).map_err(|e| e.to_string())
    }

    /// Every word of an option is taken, whatever its case, and listed with its line; another one is answered with the nearest.
    fn check<W: Word + std::fmt::Debug>(line: &str, read: impl Fn(Command) -> W) {
        let (command, option) = (line.split(' ').next().unwrap(), line.split(' ').next_back().unwrap());
        let mut cli = Cli::command();
        let help = cli.find_subcommand_mut(command).unwrap().render_long_help().to_string();
        for &(value, name, about) in W::WORDS {
            for text in [name.to_owned(), value.identifier(), name.to_uppercase()] {
                let found = parse(&format!("{line} {text}")).unwrap_or_else(|e| panic!("{e}"));
                assert_eq!(read(found), value, "{line} {text}");
            }
            let listed = help.lines().any(|l| l.contains(&format!("- {name}:")) && l.ends_with(about));
            assert!(listed, "{name} of {option} in {help}");
        }
        let slip = format!("{}x", W::WORDS[0].1);
        let e = parse(&format!("{line} {slip}")).map(|_| ()).unwrap_err();
        assert!(e.contains(option) && e.contains(&format!("unknown {} `{slip}`", W::KIND)), "{e}");
    }

    #[test]
    fn the_command_line_takes_every_word() {
        check::<SolverKind>("tune a.ron --solver", |c| match c {
            Command::Tune(args) => args.solver,
            _ => panic!("{c:?}"),
        });
        check::<SearchStart>("tune a.ron --start", |c| match c {
            Command::Tune(args) => args.start,
            _ => panic!("{c:?}"),
        });
        check::<MappingModel>("retarget a.bvh --to a.ron --model", |c| match c {
            Command::Retarget(args) => args.model,
            _ => panic!("{c:?}"),
        });
        check::<PipelineStage>("retarget a.bvh --to a.ron --stop-after", |c| match c {
            Command::Retarget(args) => args.stop_after,
            _ => panic!("{c:?}"),
        });
        check::<Axis>("render a.bvh --up", |c| match c {
            Command::Render(args) => args.clip.up.unwrap(),
            _ => panic!("{c:?}"),
        });
        check::<Strategy>("push a.ron --without", |c| match c {
            Command::Push(args) => args.physics.without[0],
            _ => panic!("{c:?}"),
        });
    }

    /// Names beside which a number or a list may stand.
    #[test]
    fn names_with_data_are_taken() {
        let root = |text: &str| match parse(&format!("render a.ron --root {text}")) {
            Ok(Command::Render(args)) => args.root.unwrap(),
            other => panic!("{other:?}"),
        };
        assert_eq!(root(RootName::Free.word()), RootChoice::Free);
        assert_eq!(root(RootName::Pinned.word()), RootChoice::Pinned);
        assert_eq!(root(RootName::Assisted.word()), RootChoice::Assisted(None));
        assert_eq!(root("Assisted:80,50"), RootChoice::Assisted(Some((80.0, 50.0))));
        let retarget = |option: &str| match parse(&format!("retarget a.bvh --to a.ron {option}")) {
            Ok(Command::Retarget(args)) => args,
            other => panic!("{other:?}"),
        };
        for &(name, word, _) in SizeRatioName::WORDS {
            if let Some(ratio) = SizeRatio::named(name) {
                assert_eq!(retarget(&format!("--size-ratio {word}")).size_ratio, ratio);
            }
        }
        assert_eq!(retarget("--size-ratio paper").size_ratio, SizeRatio::PerAxis);
        assert_eq!(retarget("--size-ratio 0.25").size_ratio, SizeRatio::Fixed(0.25));
        for (text, dofs) in [
            ("height", RefineDofs::RootHeight),
            ("root-height", RefineDofs::RootHeight),
            ("root", RefineDofs::Root),
            ("legs", RefineDofs::RootAndLegs),
            ("Root,chest", RefineDofs::Links(vec!["Root".into(), "chest".into()])),
            ("Root", RefineDofs::Links(vec!["Root".into()])), // a link's name
        ] {
            assert_eq!(retarget(&format!("--refine {text}")).refine, dofs, "{text}");
        }
    }
}
