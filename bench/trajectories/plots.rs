//! One picture for each experiment: accumulated time, failures of the filters, speed-up, and where the time goes.

use std::ops::Range;
use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;

use super::Outcome;
use super::rows::{Mode, Row};
use super::summary::{ModeSummary, Summary, failed_share};

/// Points of a line, at most.
const POINTS: usize = 160;

/// Share of a decade left free above and below the lines of a logarithmic axis.
const MARGIN: f64 = 1.3;

/// Axes of iterations are longer than the lines by this factor, for the legend.
const LEGEND: f64 = 1.36;

/// Colours of the parts of an update.
const PARTS: [RGBColor; 7] = [
    RGBColor(68, 119, 170),
    RGBColor(102, 204, 238),
    RGBColor(34, 136, 51),
    RGBColor(238, 102, 119),
    RGBColor(204, 187, 68),
    RGBColor(150, 150, 150),
    RGBColor(221, 221, 221),
];

type Panel<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// A line of a panel.
struct Line {
    mode: Mode,
    points: Vec<(f64, f64)>,
}

/// Draws the experiment.
pub fn draw(summary: &Summary, rows: &[Row], file: &Path) -> Outcome<()> {
    let root = SVGBackend::new(file, (1200, 900)).into_drawing_area();
    root.fill(&WHITE)?;
    let title = format!("{}: {} seeds, {} iterations of Lloyd", summary.name, summary.seeds, summary.iterations);
    let root = root.titled(&title, ("sans-serif", 24))?;
    let panels = root.split_evenly((2, 2));
    lines(&panels[0], "accumulated time, s", &accumulated(summary), false)?;
    lines(&panels[1], "failed the filter, %", &failures(summary, rows), true)?;
    let yardstick = summary.yardstick().map_or("", |y| y.mode.name());
    let caption = format!("times as fast as {yardstick}");
    lines(&panels[2], &caption, &speedups(summary), true)?;
    breakdown(&panels[3], summary)?;
    root.present()?;
    Ok(())
}

/// Sums up to each iteration.
fn accumulated(summary: &Summary) -> Vec<Line> {
    let line = |m: &ModeSummary| {
        let running = m.seconds.iter().scan(0.0, |sum, s| {
            *sum += s;
            Some(*sum)
        });
        let sums: Vec<f64> = running.collect();
        let points = bins(sums.len(), false).map(|bin| (bin.end as f64, sums[bin.end - 1])).collect();
        Line { mode: m.mode, points }
    };
    summary.modes.iter().map(line).collect()
}

/// Mean share of failures within bins of iterations.
fn failures(summary: &Summary, rows: &[Row]) -> Vec<Line> {
    let line = |mode: Mode| {
        let mut shares = vec![None; summary.iterations];
        for row in rows.iter().filter(|r| r.mode == mode) {
            shares[row.iteration - 1] = failed_share(row, summary.seeds);
        }
        let mean = |bin: Range<usize>| {
            let known: Vec<f64> = shares[bin.clone()].iter().copied().flatten().collect();
            (middle(&bin), 100.0 * known.iter().sum::<f64>() / known.len() as f64)
        };
        // Neither zero nor what is not known has a place on the axis.
        let points = bins(shares.len(), true).map(mean).filter(|p| p.1 > 0.0).collect();
        Line { mode, points }
    };
    summary.modes.iter().map(|m| line(m.mode)).filter(|l| !l.points.is_empty()).collect()
}

/// Ratio of the times within bins of iterations.
fn speedups(summary: &Summary) -> Vec<Line> {
    let Some(yardstick) = summary.yardstick() else { return Vec::new() };
    let line = |m: &ModeSummary| {
        let sum = |seconds: &[f64], bin: &Range<usize>| seconds[bin.clone()].iter().sum::<f64>();
        let ratio = |bin: Range<usize>| (middle(&bin), sum(&yardstick.seconds, &bin) / sum(&m.seconds, &bin));
        Line { mode: m.mode, points: bins(m.seconds.len(), true).map(ratio).collect() }
    };
    summary.modes.iter().filter(|m| m.mode != yardstick.mode).map(line).collect()
}

/// Iterations 1 to n (from 0 here) in at most [`POINTS`] ranges, equally long or equally long on a logarithmic axis.
fn bins(n: usize, logarithmic: bool) -> impl Iterator<Item = Range<usize>> {
    let end = move |i: usize| {
        let share = (i + 1) as f64 / POINTS as f64;
        let end = if logarithmic { (n as f64).powf(share) } else { n as f64 * share };
        (end.round() as usize).clamp(n.min(1), n)
    };
    let mut start = 0;
    (0..POINTS).filter_map(move |i| {
        let bin = start..end(i);
        start = bin.end;
        (!bin.is_empty()).then_some(bin)
    })
}

/// The iteration in the middle of a range.
fn middle(bin: &Range<usize>) -> f64 {
    (bin.start + 1 + bin.end) as f64 / 2.0
}

/// A panel of lines over iterations, on a logarithmic axis or not; values are on a logarithmic one.
fn lines(panel: &Panel, caption: &str, lines: &[Line], logarithmic: bool) -> Outcome<()> {
    let points = || lines.iter().flat_map(|l| &l.points);
    let last = points().map(|p| p.0).fold(2.0, f64::max);
    let low = points().map(|p| p.1).fold(f64::INFINITY, f64::min);
    let high = points().map(|p| p.1).fold(0.0, f64::max);
    // A power of ten within, so that the axis has a number; without a line, an empty panel.
    let decade = 10f64.powf(high.log10().floor());
    let values = if low <= high { (low / MARGIN).min(decade)..high * MARGIN } else { 0.1..10.0 };
    let mut builder = ChartBuilder::on(panel);
    builder
        .margin(12)
        .caption(caption, ("sans-serif", 18))
        .set_label_area_size(LabelAreaPosition::Left, 64)
        .set_label_area_size(LabelAreaPosition::Bottom, 40);
    // The two kinds of axis are two types.
    macro_rules! draw {
        ($x:expr) => {{
            let mut chart = builder.build_cartesian_2d($x, values.log_scale())?;
            chart
                .configure_mesh()
                .x_desc("iteration")
                .light_line_style(TRANSPARENT)
                .bold_line_style(BLACK.mix(0.15))
                .label_style(("sans-serif", 14))
                .x_label_formatter(&|x| if logarithmic { short(*x) } else { format!("{x:.0}") })
                .y_label_formatter(&|y| short(*y))
                .draw()?;
            for line in lines {
                let style = color(line.mode).stroke_width(2);
                chart
                    .draw_series(LineSeries::new(line.points.iter().copied(), style).point_size(dot(line)))?
                    .label(line.mode.name())
                    .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
            }
            chart
                .configure_series_labels()
                .position(SeriesLabelPosition::MiddleRight)
                .background_style(WHITE.mix(0.8))
                .border_style(BLACK.mix(0.3))
                .label_font(("sans-serif", 14))
                .draw()?;
        }};
    }
    if logarithmic {
        draw!((1.0..last.powf(LEGEND)).log_scale())
    } else {
        draw!(1.0..last * LEGEND)
    }
    Ok(())
}

/// The size of a line's points, which matter where there are hardly any.
fn dot(line: &Line) -> u32 {
    if line.points.len() < 3 { 3 } else { 0 }
}

/// A number of a logarithmic axis, without needless digits, if it has room: 1, 2 and 5 in each decade.
fn short(value: f64) -> String {
    let lead = value / 10f64.powf(value.log10().floor());
    if ![1.0, 2.0, 5.0, 10.0].iter().any(|digit| (lead - digit).abs() < 1e-6) {
        String::new()
    } else if value >= 1.0 {
        format!("{value:.0}")
    } else {
        // Rounded where the axis was not.
        let digits = (-value.log10()).ceil() as usize + usize::from(lead > 1.5);
        format!("{value:.digits$}").trim_end_matches('0').to_owned()
    }
}

/// A panel of bars, one for each of our modes: the shares of its parts.
fn breakdown(panel: &Panel, summary: &Summary) -> Outcome<()> {
    let modes: Vec<_> = summary.modes.iter().filter(|m| matches!(m.mode, Mode::Ours(_))).collect();
    let slots = modes.len() as f64 + 1.2;
    let name = |x: &f64| {
        let place = (x - 0.5).round();
        let exact = (x - 0.5 - place).abs() < 1e-6 && place >= 0.0;
        modes.get(place as usize).filter(|_| exact).map_or(String::new(), |m| m.mode.name().to_owned())
    };
    let mut chart = ChartBuilder::on(panel)
        .margin(12)
        .caption("where the time of an update goes, % (on top: mean ms)", ("sans-serif", 18))
        .set_label_area_size(LabelAreaPosition::Left, 64)
        .set_label_area_size(LabelAreaPosition::Bottom, 40)
        .build_cartesian_2d((0.0..slots).step(0.5), 0.0..108.0)?;
    chart
        .configure_mesh()
        .disable_x_mesh()
        .x_labels(2 * modes.len() + 4)
        .x_label_formatter(&name)
        .y_label_formatter(&|y| format!("{y:.0}"))
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.15))
        .label_style(("sans-serif", 14))
        .draw()?;
    let Some(first) = modes.first() else { return Ok(()) };
    let mut tops = vec![0.0; modes.len()];
    for (i, (part, _)) in first.parts.iter().enumerate() {
        let style = PARTS[i % PARTS.len()].filled();
        let mut bars = Vec::new();
        for (slot, (mode, top)) in modes.iter().zip(&mut tops).enumerate() {
            let whole: f64 = mode.parts.iter().map(|p| p.1).sum();
            let base = *top;
            *top += 100.0 * mode.parts[i].1 / whole;
            bars.push(Rectangle::new([(slot as f64 + 0.15, base), (slot as f64 + 0.85, *top)], style));
        }
        chart
            .draw_series(bars)?
            .label(*part)
            .legend(move |(x, y)| Rectangle::new([(x, y - 5), (x + 14, y + 5)], style));
    }
    let label = |(slot, m): (usize, &&ModeSummary)| {
        let ms = m.mean() * 1e3;
        let text = if ms < 10.0 { format!("{ms:.2}") } else { format!("{ms:.0}") };
        Text::new(text, (slot as f64 + 0.3, 106.0), ("sans-serif", 14))
    };
    chart.draw_series(modes.iter().enumerate().map(label))?;
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::MiddleRight)
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK.mix(0.3))
        .label_font(("sans-serif", 14))
        .draw()?;
    Ok(())
}

/// The colour of a mode, the same in every panel.
fn color(mode: Mode) -> RGBColor {
    match mode.name() {
        "bicell" => RGBColor(0, 90, 181),
        "paper" => RGBColor(220, 110, 0),
        "vertex" => RGBColor(26, 133, 80),
        "check" => RGBColor(150, 60, 170),
        "rebuild" => RGBColor(120, 120, 120),
        "cgal-rebuild" => RGBColor(0, 0, 0),
        _ => RGBColor(180, 40, 40),
    }
}
