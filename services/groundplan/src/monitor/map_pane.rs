//! Map pane: two pixels per character, each showing the cell of highest priority below it.

use grid::Class;
use messages::Grid;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Color;

/// The grid of the storey that is shown.
#[derive(Clone, Copy)]
pub(crate) struct GridPixels<'a> {
    pub(crate) grid: Grid<'a>,
}

/// What a pixel shows, the more important the higher: nothing that is thinner than a pixel vanishes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Pixel {
    Outside,
    Unknown,
    Free,
    Space,
    KeptOut,
    Blocked,
    Stair,
    Door,
    Obstacle,
}

impl Pixel {
    fn of(grid: &Grid<'_>, cell: usize, shows_keepout: bool) -> Self {
        match grid.class_of(cell) {
            Class::Stair | Class::Ramp => Self::Stair,
            Class::Door => Self::Door,
            Class::None if grid.planning[cell] == 100 => Self::Blocked,
            Class::None if shows_keepout && grid.is_keepout(cell) && grid.floor[cell] != 0 => Self::KeptOut,
            Class::None if grid.planning[cell] != 0 => Self::Unknown,
            Class::None if grid.space[cell] != 0 => Self::Space,
            Class::None => Self::Free,
            _ => Self::Obstacle,
        }
    }

    fn colour(self) -> Color {
        match self {
            Self::Outside => Color::Reset,
            Self::Unknown => Color::Rgb(40, 40, 44),
            Self::Free => Color::Rgb(235, 235, 235),
            Self::Space => Color::Rgb(190, 210, 255),
            Self::KeptOut => Color::Rgb(225, 190, 150),
            Self::Blocked => Color::Rgb(255, 180, 180),
            Self::Stair => Color::Rgb(255, 255, 0),
            Self::Door => Color::Rgb(0, 200, 0),
            Self::Obstacle => Color::Rgb(90, 90, 90),
        }
    }
}

impl GridPixels<'_> {
    /// Draws the map as large as it fits, upper edge up.
    pub(crate) fn draw(&self, area: Rect, shows_keepout: bool, buffer: &mut Buffer) {
        let (width, height) = (self.grid.head.width as usize, self.grid.head.height as usize);
        let (columns, rows) = (usize::from(area.width), 2 * usize::from(area.height));
        if columns == 0 || rows == 0 || width == 0 || height == 0 {
            return;
        }
        let side = width.div_ceil(columns).max(height.div_ceil(rows));
        let pixels = [width.div_ceil(side), height.div_ceil(side)];
        let pixel = |x: usize, y: usize| {
            if x >= pixels[0] || y >= pixels[1] {
                return Pixel::Outside;
            }
            // Row 0 of a grid is its lowest.
            let top = height - y * side;
            let cells = (top.saturating_sub(side)..top)
                .flat_map(|row| (x * side..width.min((x + 1) * side)).map(move |column| row * width + column));
            cells.map(|cell| Pixel::of(&self.grid, cell, shows_keepout)).max().unwrap_or(Pixel::Outside)
        };
        for y in 0..pixels[1].div_ceil(2) {
            for x in 0..pixels[0] {
                let [upper, lower] = [pixel(x, 2 * y), pixel(x, 2 * y + 1)];
                let at = (area.x + x as u16, area.y + y as u16);
                if let Some(cell) = buffer.cell_mut(at) {
                    cell.set_char('▀').set_fg(upper.colour()).set_bg(lower.colour());
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{ArchiveBuffer, GridHead, GridWriter};

    #[test]
    fn a_wall_of_one_cell_is_seen_however_small_the_pane() {
        let head = GridHead { cell_tenths: 500, width: 100, height: 60, ..GridHead::EMPTY };
        let mut buffer = ArchiveBuffer::zeroed(GridWriter::len_of(6_000));
        let mut writer = GridWriter::new(buffer.bytes_mut(), &head);
        let layers = writer.layers();
        // The lowest row, all along.
        layers.class[..100].fill(Class::Wall.id());
        layers.planning[..100].fill(100);
        writer.seal();
        let map = GridPixels { grid: Grid::open(buffer.bytes()).unwrap() };
        let area = Rect::new(0, 0, 10, 4);
        let mut drawn = Buffer::empty(area);
        map.draw(area, false, &mut drawn);
        let [first, last] = [(0, 0), (9, 2)].map(|at| drawn.cell(at).unwrap().clone());
        assert_eq!(first.fg, Pixel::Free.colour());
        assert_eq!(
            (last.symbol(), last.bg),
            ("▀", Pixel::Obstacle.colour()),
            "six rows of pixels, the wall in the last"
        );
    }
}
