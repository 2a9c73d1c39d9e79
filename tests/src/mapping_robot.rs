//! A robot that publishes a map of its own, and what daemons make of what it sees.

use super::Maps;
use super::live::Live;
use bus::{Bus, Daemon, Origin, Publisher, Waiter, topics};
use daemon::SiteConfig;
use messages::{InputHashes, SlamMap, SlamMapHead};
use serde_json::Value;

/// A robot that publishes a map of the ground floor as its own.
pub struct MappingRobot {
    publisher: Publisher<topics::SlamMap>,
    _bus: (Bus, Waiter),
    pub cells: Vec<i8>,
    size: [u32; 2],
    epoch: u64,
}

impl MappingRobot {
    pub fn of(live: &Live, maps: &Maps, map: &str) -> Self {
        let config = SiteConfig::read(&live.config()).unwrap();
        let (bus, waiter) = Bus::join(&config.domain().unwrap(), Daemon::Robot).unwrap();
        let directory = maps.manifest["storeys"][0]["directory"].as_str().unwrap();
        let bytes = std::fs::read(maps.path().join(directory).join(map)).unwrap();
        let (width, height, pixels) = grid::decode_pgm(&bytes).unwrap();
        let cells = pixels.into_iter().map(|p| match p {
            grid::FREE => 0,
            grid::OCCUPIED => 100,
            _ => -1,
        });
        let publisher = bus.publisher(topics::SlamMap, 1 << 20).unwrap();
        let size = [width as u32, height as u32];
        Self { publisher, _bus: (bus, waiter), cells: cells.collect(), size, epoch: 0 }
    }

    /// The robot sees through a rectangle of the model's map: x from, y from, x to, y to.
    pub fn sees_through(&mut self, maps: &Maps, [x0, y0, x1, y1]: [f64; 4]) {
        let origin = [0, 1].map(|k| maps.manifest["storeys"][0]["origin_m"][k].as_f64().unwrap());
        for (index, cell) in self.cells.iter_mut().enumerate() {
            let (column, row) = (index as u32 % self.size[0], index as u32 / self.size[0]);
            let at = [origin[0] + (f64::from(column) + 0.5) * 0.05, origin[1] + (f64::from(row) + 0.5) * 0.05];
            if x0 < at[0] && at[0] < x1 && y0 < at[1] && at[1] < y1 {
                *cell = 0;
            }
        }
    }

    pub fn publish(&mut self, x_m: f64) {
        let [width, height] = self.size;
        let head = SlamMapHead { resolution_m: 0.05, origin: [x_m, 1.0, 0.0], width, height };
        self.epoch += 1;
        let origin = Origin { epoch: self.epoch, frame_epoch: 0, inputs: InputHashes::default() };
        self.publisher.publish_copy(SlamMap::write(&head, &self.cells).bytes(), origin).unwrap();
    }
}

/// A pixel of the planning map that the daemons hold, at a place of the ground floor.
pub fn planning_at(live: &Live, [x_m, y_m]: [f64; 2]) -> u8 {
    let out = live.home.path().join("exported");
    live.text(&[&"export", &out]);
    let manifest: Value = serde_json::from_slice(&std::fs::read(out.join("manifest.json")).unwrap()).unwrap();
    let storey = &manifest["storeys"][0];
    let pgm = std::fs::read(out.join(storey["directory"].as_str().unwrap()).join("planning.pgm")).unwrap();
    let (width, _, pixels) = grid::decode_pgm(&pgm).unwrap();
    let cell = [(0, x_m), (1, y_m)].map(|(k, c)| ((c - storey["origin_m"][k].as_f64().unwrap()) / 0.05) as usize);
    pixels[cell[1] * width + cell[0]]
}
