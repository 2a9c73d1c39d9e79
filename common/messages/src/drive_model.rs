//! By what a robot chooses its ways, and what of its drive decides time and energy of them.

use crate::tag::Tag;
use bytemuck::{CheckedBitPattern, NoUninit, Pod, Zeroable};

/// Joules in a watt-hour, in which files and answers have energies.
pub const JOULES_PER_WH: f64 = 3600.0;

/// By what ways are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum WayCost {
    /// The shortest.
    Length = 0,
    /// The fastest.
    Time = 1,
    /// That which takes the least energy.
    Energy = 2,
}

impl WayCost {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Length, Self::Time, Self::Energy];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Length => "length",
            Self::Time => "time",
            Self::Energy => "energy",
        }
    }
}

/// How fast a robot drives, and what energy that takes.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct DriveModel {
    /// Speed along level ground and slopes.
    pub speed_m_s: f64,
    /// Seconds that each metre of climb adds.
    pub climb_s_per_m: f64,
    /// Mass with all load in kilograms; 0 if it is unknown, as are energies then.
    pub mass_kg: f64,
    /// Coefficient of rolling resistance.
    pub rolling_resistance: f64,
    /// Share of the energy of the battery that arrives at the wheels.
    pub drive_efficiency: f64,
    /// Power of all that runs while the robot drives or stands, in watts.
    pub idle_w: f64,
    /// By what ways are chosen.
    pub cost: Tag<WayCost>,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<DriveModel>() == 56);

impl DriveModel {
    /// A robot of which only the speed is known.
    pub const DEFAULT: Self = Self {
        speed_m_s: 0.5,
        climb_s_per_m: 0.0,
        mass_kg: 0.0,
        rolling_resistance: 0.02,
        drive_efficiency: 0.7,
        idle_w: 0.0,
        cost: Tag::numbered(WayCost::Length as u32),
        reserved: 0,
    };

    /// True if energies are known.
    pub fn has_energy(&self) -> bool {
        self.mass_kg > 0.0
    }

    /// True if slopes or energies were asked for.
    pub fn is_asked_for(&self) -> bool {
        self.has_energy() || self.climb_s_per_m > 0.0 || self.cost != WayCost::Length
    }

    /// True if all its numbers are.
    pub(crate) fn is_finite(&self) -> bool {
        let Self { speed_m_s, climb_s_per_m, mass_kg, rolling_resistance, drive_efficiency, idle_w, .. } = *self;
        [speed_m_s, climb_s_per_m, mass_kg, rolling_resistance, drive_efficiency, idle_w].iter().all(|n| n.is_finite())
    }
}
