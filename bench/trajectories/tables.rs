//! Tables of a run: CSV for programs, Markdown for people, and their place in `bench/README.md`.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use tetcvt::delaunay::Method;

use super::Outcome;
use super::rows::Mode;
use super::scaling::Size;
use super::summary::{ModeSummary, Summary};

/// The README's lines between which the tables stand.
const BEGIN: &str = "<!-- trajectories: what follows is written by bench/trajectories.sh --publish -->";
const END: &str = "<!-- trajectories: end -->";

/// Everything, one line a mode of an experiment.
pub fn csv(summaries: &[Summary], file: &Path) -> Outcome<()> {
    let mut text = String::from(
        "experiment,seeds,iterations,mode,measured,total_s,mean_s,speedup,late_s,late_speedup,failed_percent,flips,reversed,\
         predicates,rebuilt,rebuilt_after_20,worst_to_rebuild,worst_iteration",
    );
    let parts = summaries.first().and_then(|s| s.modes.first()).map(|m| &m.parts[..]).unwrap_or_default();
    for (part, _) in parts {
        write!(text, ",{part}_s")?;
    }
    text.push('\n');
    for s in summaries {
        for m in &s.modes {
            let speedup = s.yardstick().map(|y| (y.mean() / m.mean(), y.late() / m.late()));
            let worst = s.mode(Mode::Ours(Method::Rebuild)).map(|rebuild| m.worst_against(rebuild));
            write!(
                text,
                "{},{},{},{},{},{:.6},{:.7},{},{:.7},{},{},{:.1},{:.3},{:.1},{},{},{},{}",
                s.name,
                s.seeds,
                s.iterations,
                m.mode.name(),
                m.measured,
                m.total(),
                m.mean(),
                optional(speedup.map(|v| v.0), 3),
                m.late(),
                optional(speedup.map(|v| v.1), 3),
                optional(m.failed_percent, 4),
                m.flips,
                m.reversed,
                m.predicates,
                m.rebuilt,
                m.rebuilt_settled,
                optional(worst.map(|w| w.0), 3),
                worst.map_or(String::new(), |w| w.1.to_string()),
            )?;
            for (_, seconds) in &m.parts {
                write!(text, ",{seconds:.7}")?;
            }
            text.push('\n');
        }
    }
    fs::write(file, text).map_err(|e| format!("{}: {e}", file.display()).into())
}

/// The tables; `origins` say when and where each part of them was measured.
pub fn markdown(summaries: &[Summary], sizes: &[Size], origins: &[(String, &str)]) -> Outcome<String> {
    let mut text = String::new();
    let same = |about: &String| origins.iter().filter(|o| o.0 == *about).map(|o| o.1).collect::<Vec<_>>();
    for (about, name) in origins {
        let parts = same(about);
        match parts.len() {
            all if all == origins.len() => text = format!("{about}\n"),
            // Once, at the first part that it tells of.
            _ if parts[0] == *name => writeln!(text, "- {}: {about}", parts.join(", "))?,
            _ => {}
        }
    }
    if !summaries.is_empty() {
        means(summaries, &mut text)?;
        details(summaries, &mut text)?;
    }
    if !sizes.is_empty() {
        scaling(sizes, &mut text)?;
    }
    Ok(text)
}

/// The paper's Table 1.
fn means(summaries: &[Summary], text: &mut String) -> Outcome<()> {
    let run = |m: &Mode| summaries.iter().any(|s| s.mode(*m).is_some());
    // From the slowest to the fastest: the reverse of their order.
    let mut modes: Vec<Mode> = Mode::all().filter(run).collect();
    modes.reverse();
    text.push_str(
        "\nMilliseconds of an update, mean over all iterations, and how many times faster than CGAL's rebuild:\n\n",
    );
    text.push_str("| experiment | seeds | iterations |");
    modes.iter().try_for_each(|m| write!(text, " {} |", m.name()))?;
    text.push_str("\n|---|---|---|");
    text.push_str(&"---|".repeat(modes.len()));
    for s in summaries {
        write!(text, "\n| {} | {} | {} |", s.name, s.seeds, s.iterations)?;
        for mode in &modes {
            match (s.mode(*mode), s.mode(Mode::CgalRebuild)) {
                (Some(m), Some(_)) if *mode == Mode::CgalRebuild => write!(text, " {} |", milliseconds(m.mean()))?,
                (Some(m), Some(y)) => write!(text, " {} ({}) |", milliseconds(m.mean()), times(y.mean() / m.mean()))?,
                (Some(m), None) => write!(text, " {} |", milliseconds(m.mean()))?,
                (None, _) => text.push_str(" |"),
            }
        }
    }
    text.push('\n');
    Ok(())
}

/// What each filter lets through, and what the requirements ask for.
fn details(summaries: &[Summary], text: &mut String) -> Outcome<()> {
    text.push_str(
        "\n\"failed\": bi-cells (vertices for `vertex`) that failed the filter; \"rebuilt\": triangulations built anew, in brackets after \
         iteration 20; \"worst\": the slowest iteration against our rebuild of the same points; the last three columns \
         are medians over the last quarter of the iterations:\n\n",
    );
    text.push_str("| experiment | mode | failed % | flips | reversed | rebuilt | worst / rebuild | late ms | CGAL's rebuild / it | check / it |\n");
    text.push_str("|---|---|---|---|---|---|---|---|---|---|\n");
    for s in summaries {
        for m in s.modes.iter().filter(|m| matches!(m.mode, Mode::Ours(method) if method != Method::Rebuild)) {
            let worst = s.mode(Mode::Ours(Method::Rebuild)).map(|rebuild| m.worst_against(rebuild));
            let late = |mode: Mode| s.mode(mode).map_or(String::new(), |o: &ModeSummary| times(o.late() / m.late()));
            writeln!(
                text,
                "| {} | {} | {} | {:.0} | {:.1} | {} ({}) | {} | {} | {} | {} |",
                s.name,
                m.mode.name(),
                optional(m.failed_percent, 2),
                m.flips,
                m.reversed,
                m.rebuilt,
                m.rebuilt_settled,
                worst.map_or(String::new(), |(ratio, k)| format!("{ratio:.2} (iteration {k})")),
                milliseconds(m.late()),
                late(Mode::CgalRebuild),
                late(Mode::Ours(Method::Check)),
            )?;
        }
    }
    Ok(())
}

/// How cost and memory grow.
fn scaling(sizes: &[Size], text: &mut String) -> Outcome<()> {
    text.push_str(
        "\nMicroseconds a seed, and bytes a seed of triangulation, points and filter, as they grow; the bunny from a jittered lattice, \
         medians over the second half of the iterations:\n\n",
    );
    text.push_str("| seeds | bicell | check | build | CGAL's build | bytes, built | bytes, followed by bicell |\n|---|---|---|---|---|---|---|\n");
    for size in sizes {
        let each = |seconds: f64| seconds * 1e6 / size.seeds as f64;
        writeln!(
            text,
            "| {} | {:.3} | {:.3} | {:.2} | {} | {:.0} | {:.0} |",
            size.seeds,
            each(size.bicell),
            each(size.check),
            each(size.build),
            optional(size.cgal.map(each), 2),
            size.built_bytes as f64 / size.seeds as f64,
            size.followed_bytes as f64 / size.seeds as f64,
        )?;
    }
    if let [first, .., last] = sizes {
        let growth = |f: &dyn Fn(&Size) -> f64| f(last) / last.seeds as f64 / (f(first) / first.seeds as f64);
        writeln!(
            text,
            "\nFrom {} to {} seeds the cost of a seed grows by a factor of {:.2} in an update, of {:.2} in building.",
            first.seeds,
            last.seeds,
            growth(&|s| s.bicell),
            growth(&|s| s.build)
        )?;
    }
    Ok(())
}

/// Replaces what stands between the README's marks by `text` and the plots in `plots`, which is relative to the README.
pub fn publish(readme: &Path, text: &str, plots: &[String]) -> Outcome<()> {
    let old = fs::read_to_string(readme).map_err(|e| format!("{}: {e}", readme.display()))?;
    let missing = || format!("{}: the marks \"{BEGIN}\" and \"{END}\" are not there", readme.display());
    let (before, rest) = old.split_once(BEGIN).ok_or_else(missing)?;
    let (_, after) = rest.split_once(END).ok_or_else(missing)?;
    let mut new = format!("{before}{BEGIN}\n\n{text}\n");
    for plot in plots {
        let name = plot.rsplit('/').next().unwrap_or(plot).trim_end_matches(".svg");
        writeln!(new, "![{name}: accumulated time, failures, speed-up and breakdown]({plot})\n")?;
    }
    new.push_str(END);
    new.push_str(after);
    fs::write(readme, new).map_err(|e| format!("{}: {e}", readme.display()).into())
}

fn optional(value: Option<f64>, digits: usize) -> String {
    value.map_or(String::new(), |v| format!("{v:.digits$}"))
}

fn milliseconds(seconds: f64) -> String {
    let ms = seconds * 1e3;
    let digits = if ms < 10.0 { 2 } else { 1 };
    format!("{ms:.digits$}")
}

fn times(ratio: f64) -> String {
    if ratio < 10.0 { format!("{ratio:.2}x") } else { format!("{ratio:.1}x") }
}
