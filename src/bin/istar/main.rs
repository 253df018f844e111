//! The `istar` command: parse, run, report. One file a command.

mod archive;
mod compare;
mod decode;
mod encode;
mod files;
mod info;
mod merge;
mod names;
mod pictures;
mod progress;
mod render;
mod rows;
mod stream;
mod styles;
mod survey;
mod tell;
mod vectors;
mod verify;
mod view;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Images as a small raster plus the graph of their regions: sharp at any zoom.
#[derive(Parser)]
#[command(name = "istar", version, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Encode(encode::Args),
    Decode(decode::Args),
    Render(render::Args),
    Compare(compare::Args),
    Info(info::Args),
    Verify(verify::Args),
    Merge(merge::Args),
    View(view::Args),
}

/// What went wrong, in one line for stderr.
type Outcome = Result<(), String>;

fn main() -> ExitCode {
    // `parse` itself ends the program with 2 where the words do not fit.
    let outcome = match Cli::parse().command {
        Command::Encode(args) => encode::run(&args),
        Command::Decode(args) => decode::run(&args),
        Command::Render(args) => render::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Verify(args) => verify::run(&args),
        Command::Merge(args) => merge::run(&args),
        Command::View(args) => view::run(&args),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            // One line, whatever the message is made of.
            tell::aside(&message.replace(['\n', '\r'], " "));
            ExitCode::FAILURE
        }
    }
}
