//! Vectors and rectangles of the plane, in metres.

/// A point or a direction.
pub type Vector = [f64; 2];

pub(crate) fn sum(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1]]
}

pub(crate) fn difference(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1]]
}

pub(crate) fn scaled(a: Vector, by: f64) -> Vector {
    [a[0] * by, a[1] * by]
}

/// From `a`, this far in a direction.
pub(crate) fn moved(a: Vector, direction: Vector, far: f64) -> Vector {
    [a[0] + direction[0] * far, a[1] + direction[1] * far]
}

pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(crate) fn distance(a: Vector, b: Vector) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}

/// A quarter turn to the left.
pub(crate) fn left_of(a: Vector) -> Vector {
    [-a[1], a[0]]
}

pub(crate) fn direction_of(yaw_rad: f64) -> Vector {
    let (sin, cos) = libm::sincos(yaw_rad);
    [cos, sin]
}

/// `a` turned by the angle of the unit vector `by`.
pub(crate) fn turned(a: Vector, by: Vector) -> Vector {
    [by[0] * a[0] - by[1] * a[1], by[1] * a[0] + by[0] * a[1]]
}

/// A rectangle in any direction.
#[derive(Debug, Clone, Copy)]
pub struct Rectangle {
    /// Its middle.
    pub centre: Vector,
    /// Unit vector along its length.
    pub along: Vector,
    /// Half its length and half its width.
    pub half: [f64; 2],
}

impl Rectangle {
    /// Of this middle, direction, length and width.
    pub fn new(centre: Vector, along: Vector, length: f64, width: f64) -> Self {
        Self { centre, along, half: [length / 2.0, width / 2.0] }
    }

    /// A line of some width between two points.
    pub(crate) fn between(a: Vector, b: Vector, width: f64) -> Self {
        let length = distance(a, b).max(1e-9);
        Self::new(scaled(sum(a, b), 0.5), scaled(difference(b, a), 1.0 / length), length, width)
    }

    pub(crate) fn contains(&self, p: Vector) -> bool {
        let d = difference(p, self.centre);
        dot(d, self.along).abs() <= self.half[0] && dot(d, left_of(self.along)).abs() <= self.half[1]
    }

    /// The point at these metres along and across from the middle.
    pub(crate) fn at(&self, [along, across]: [f64; 2]) -> Vector {
        moved(moved(self.centre, self.along, along), left_of(self.along), across)
    }

    /// Larger by this much on all sides.
    pub(crate) fn grown(&self, by: f64) -> Self {
        Self { half: self.half.map(|h| h + by), ..*self }
    }

    pub(crate) fn shifted(&self, by: Vector) -> Self {
        Self { centre: sum(self.centre, by), ..*self }
    }

    /// The lower left and the upper right corner of the axis-parallel box around it.
    pub(crate) fn bounds(&self) -> [Vector; 2] {
        let [c, s] = self.along.map(f64::abs);
        let reach = [c * self.half[0] + s * self.half[1], s * self.half[0] + c * self.half[1]];
        [difference(self.centre, reach), sum(self.centre, reach)]
    }
}
