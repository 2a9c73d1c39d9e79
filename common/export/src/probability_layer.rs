//! `probability.png` and `probability.{pgm,yaml}`: the probability that an obstacle is in a cell.

use crate::image::{Image, Rgb, picture};
use crate::input::{ExportFile, ExportInput, ProbabilityInput};
use crate::lettering::{LetterSize, Lettering};
use embedded_graphics::geometry::{Point, Size};
use grid::{MapMode, MapYaml, encode_pgm, overlapped_cells};
use messages::{Grid, NONE};
use std::collections::BTreeSet;

/// Where nothing can be, on floor and elsewhere.
const FLOOR: Rgb = [255, 255, 255];
const NO_FLOOR: Rgb = [225, 225, 225];

/// What is certain to be there.
const CERTAIN: Rgb = [90, 90, 90];

const INK: Rgb = [40, 40, 40];

/// Colours from improbable to probable: YlOrRd of ColorBrewer (Harrower and Brewer, The Cartographic Journal 40, 2003).
const RAMP: [Rgb; 5] = [[255, 237, 160], [254, 178, 76], [252, 78, 42], [189, 0, 38], [110, 0, 30]];

/// Room for the legend: a bar, and a line of text above and below it.
const LEGEND: Size = Size::new(210, 44);
const BAR: [i32; 2] = [200, 10];

/// The picture and the map of a storey.
pub(crate) fn files(
    folder: &str,
    input: &ExportInput<'_>,
    grid: &Grid<'_>,
    probability: &ProbabilityInput<'_>,
) -> [ExportFile; 3] {
    let spec = grid.spec();
    let width = spec.width as usize;
    let percent = percent_of_cells(input, grid, probability);
    let colour = |index: usize| match percent[index] {
        0 if grid.floor[index] != 0 => FLOOR,
        0 => NO_FLOOR,
        100 => CERTAIN,
        percent => ramp(percent),
    };
    let mut image = Image::new(width, (0..spec.n_cells()).map(colour).collect()).with_room_below(LEGEND, FLOOR);
    draw_legend(input, spec.height as i32, &mut image);
    let pixels: Vec<u8> = percent.iter().map(|&percent| pixel_of_percent(percent)).collect();
    let pgm = encode_pgm(width, &pixels);
    let yaml = MapYaml { image: "probability.pgm", spec: &spec, mode: MapMode::Scale }.to_string();
    [
        ExportFile::new(format!("{folder}/probability.png"), picture(image)),
        ExportFile::new(format!("{folder}/probability.pgm"), pgm),
        ExportFile::new(format!("{folder}/probability.yaml"), yaml),
    ]
}

/// Of every cell the probability in per cent that the likeliest element over it is there; doors that the robot passes are no
/// obstacles. 0 and 100 are certain: what is possible is at least 1, and what is not certain at most 99.
fn percent_of_cells(input: &ExportInput<'_>, grid: &Grid<'_>, probability: &ProbabilityInput<'_>) -> Vec<u8> {
    let spec = grid.spec();
    let passable = |d: &&messages::DoorPassageRecord| !d.passage.get().is_closed();
    let doors = input.index.doors.iter().filter(|d| d.map_storey == grid.head.map_storey);
    let passable: BTreeSet<u32> = doors.filter(passable).map(|d| input.site.doors[d.door as usize].element).collect();
    let mut percent = vec![0u8; spec.n_cells()];
    let footprints = input.footprints.get(grid.head.map_storey as usize).copied().unwrap_or_default();
    for (element, footprint) in footprints.iter().filter(|(e, _)| *e != NONE && !passable.contains(e)) {
        let of_element = percent_of(probability.there[*element as usize]);
        if of_element == 0 {
            continue;
        }
        let footprint = footprint.get(|| input.site.element_meshes(&input.site.elements[*element as usize]));
        for run in overlapped_cells(&footprint.area, &footprint.lines, &spec) {
            let row = run.row as usize * spec.width as usize;
            let cells = &mut percent[row + run.start as usize..row + run.end as usize];
            cells.iter_mut().for_each(|cell| *cell = of_element.max(*cell));
        }
    }
    percent
}

fn percent_of(probability: f64) -> u8 {
    if probability <= 0.0 {
        0
    } else if probability >= 1.0 {
        100
    } else {
        (100.0 * probability).round().clamp(1.0, 99.0) as u8
    }
}

/// The pixel that map servers read as this value in the mode `scale`, with the thresholds 0 and 1.
pub(crate) fn pixel_of_percent(percent: u8) -> u8 {
    255 - ((u32::from(percent) * 255 + 50) / 100) as u8
}

/// The colour of a probability between 0 and 100 per cent.
fn ramp(percent: u8) -> Rgb {
    let at = u32::from(percent.min(99)) * (RAMP.len() as u32 - 1);
    let (left, part) = ((at / 100) as usize, at % 100);
    let mixed = |channel: usize| {
        let [from, to] = [RAMP[left], RAMP[left + 1]].map(|colour| u32::from(colour[channel]));
        ((from * (100 - part) + to * part) / 100) as u8
    };
    [mixed(0), mixed(1), mixed(2)]
}

/// What the colours mean, and of which date.
fn draw_legend(input: &ExportInput<'_>, top: i32, image: &mut Image) {
    let mut text = |text: &str, x: i32, y: i32| {
        Lettering::new(text, LetterSize::Medium).draw(Point::new(x, top + y), INK, image);
    };
    let time = |t: Option<frames::PlanTime>| t.map_or(String::new(), |t| t.to_string());
    let head = input.schedule_state.head;
    text(&format!("obstacle at {}", time(head.plan_time())), 4, 4);
    text("0 %", 4, 32);
    text("50 %", 4 + BAR[0] / 2 - 10, 32);
    text("100 %", 4 + BAR[0] - 25, 32);
    for x in 0..BAR[0] {
        let colour = match (x * 101 / BAR[0]).clamp(0, 100) as u8 {
            0 => NO_FLOOR,
            100 => CERTAIN,
            percent => ramp(percent),
        };
        (0..BAR[1]).for_each(|y| image.set(Point::new(4 + x, top + 18 + y), colour));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_per_cent_is_read_back_from_its_pixel() {
        // As map_server of Nav2 reads the mode `scale` with the thresholds 0 and 1.
        let read = |pixel: u8| (f64::from(255 - pixel) / 255.0 * 100.0).round() as u8;
        for percent in 0..=100 {
            assert_eq!(read(pixel_of_percent(percent)), percent);
        }
    }

    #[test]
    fn only_certainty_is_0_or_100_per_cent() {
        let found = [0.0, 0.001, 0.004, 0.5, 0.996, 0.9995, 1.0].map(percent_of);
        assert_eq!(found, [0, 1, 1, 50, 99, 99, 100]);
    }

    #[test]
    fn the_ramp_goes_from_its_first_colour_to_its_last() {
        assert_eq!((ramp(0), ramp(50)), (RAMP[0], RAMP[2]));
        assert!(ramp(99)[0] < ramp(80)[0] && ramp(20)[1] > ramp(60)[1]);
    }
}
