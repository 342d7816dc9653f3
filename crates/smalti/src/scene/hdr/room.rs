//! The contents and the illumination of the room. Lengths are in m, with x to the right, y up and z away from
//! the camera. Light is in cd/m²: the luminance of a white diffuser (illuminance over π) or, for a directly
//! visible source, of that source.

use super::geometry::{Shape, Vec3, add, dot, meets, scale, sub, unit};
use crate::scene::macbeth;

/// Indices of reflectances: the ColorChecker comes first, then these greys.
pub(super) const WHITE: usize = 24;
pub(super) const BLACK: usize = 25;
/// Reflectance of each grey.
pub(super) const GREYS: [f64; 2] = [0.82, 0.02];
/// ColorChecker patches used as materials.
const BROWN: usize = 0;
const SKY: usize = 2;
const FOLIAGE: usize = 3;
const GREEN: usize = 13;
const ORANGE: usize = 6;
const RED: usize = 14;
const BLUE: usize = 12;
const YELLOW: usize = 15;

/// Corners of the room, and thickness of the wall towards the corridor.
const LOW: Vec3 = [-2.6, 0.0, -0.6];
const HIGH: Vec3 = [2.6, 2.6, 4.6];
const WALL: f64 = 0.15;
/// Openings in the back wall: x from, x to, y from, y to.
const WINDOW: [f64; 4] = [-2.0, -0.35, 0.95, 2.2];
const DOOR: [f64; 4] = [1.35, 2.2, 0.0, 2.05];
const CORRIDOR: [f64; 2] = [1.25, 3.9];
const CORRIDOR_END: f64 = 8.3;
/// Rays that miss this bounding box cannot hit its contents.
const TABLE_BOUNDS: [Vec3; 2] = [[-0.36, -0.01, 2.94], [1.16, 1.23, 3.76]];
/// A clear halogen bulb of 150 cd; its luminance is the mean over its disc.
const BULB: Vec3 = [0.62, 1.22, 3.35];
const BULB_RADIUS: f64 = 0.035;
const BULB_CD: f64 = 150.0;
/// Illuminance of the sun on a perpendicular plane, lux, and the direction towards it.
const SUN_LUX: f64 = 60_000.0;
const TO_SUN: Vec3 = [-0.22, 0.62, 0.75];
/// Luminance of the sky as visible through the window from the room.
const SKY_CD_M2: f64 = 3500.0;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Surface {
    /// A reflectance times a factor.
    Matt(usize, f64),
    /// Boards of two tones along z.
    Boards,
    /// The ColorChecker on the wall.
    Chart,
    Mirror,
    Bulb,
}

/// Light along a viewing ray: a reflectance times an amount of daylight and an amount of lamplight.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shade {
    pub(super) reflectance: usize,
    pub(super) daylight: f64,
    pub(super) lamplight: f64,
}

/// The room, built once per image.
pub(super) struct Room {
    /// Furniture casts shadows; the walls enclose the room.
    furniture: Vec<(Shape, Surface)>,
    /// The table and the objects on it, within [`TABLE_BOUNDS`].
    table: Vec<(Shape, Surface)>,
    walls: Vec<(Shape, Surface)>,
}

impl Room {
    pub(super) fn new() -> Self {
        let block = |low: Vec3, high: Vec3, surface| (Shape::Block(low, high), surface);
        let ball = |centre: Vec3, radius, surface| (Shape::Sphere(centre, radius), surface);
        let matt = |reflectance| Surface::Matt(reflectance, 1.0);
        let ([x0, y0, z0], [x1, y1, z1]) = (LOW, HIGH);
        let (back, end) = (z1 + WALL, CORRIDOR_END);
        let ([wl, wr, wb, wt], [dl, dr, _, dt], [cl, cr]) = (WINDOW, DOOR, CORRIDOR);
        let plaster = matt(WHITE);
        let mut walls = vec![
            block([x0 - 1.0, y0 - 1.0, z0], [x1 + 1.0, y0, z1], Surface::Boards),
            block([x0 - 1.0, y1, z0], [x1 + 1.0, y1 + 1.0, back], plaster),
            block([x0 - 1.0, y0, z0], [x0, y1, back], Surface::Matt(SKY, 1.9)),
            block([x1, y0, z0], [x1 + 1.0, y1, back], plaster),
            block([x0, y0, z0 - 1.0], [x1, y1, z0], plaster),
            // The back wall around window and door.
            block([x0, y0, z1], [wl, y1, back], plaster),
            block([wl, y0, z1], [wr, wb, back], plaster),
            block([wl, wt, z1], [wr, y1, back], plaster),
            block([wr, y0, z1], [dl, y1, back], plaster),
            block([dl, dt, z1], [dr, y1, back], plaster),
            block([dr, y0, z1], [x1, y1, back], plaster),
            // The corridor and the objects in it.
            block([dl, y0 - 1.0, z1], [dr, y0, back], matt(BROWN)),
            block([cl, y0 - 1.0, back], [cr, y0, end], matt(BROWN)),
            block([cl - 1.0, y0, back], [cl, y1, end], plaster),
            block([cr, y0, back], [cr + 1.0, y1, end], plaster),
            block([cl, y1 - 0.2, back], [cr, y1 + 1.0, end], plaster),
            block([cl, y0, end], [cr, y1, end + 1.0], plaster),
            block([2.35, 0.0, 6.9], [2.75, 1.0, 7.3], matt(BLACK)),
            ball([2.55, 1.2, 7.1], 0.2, matt(RED)),
        ];
        for (x, width) in [(wl, 0.05), ((wl + wr) / 2.0, 0.03), (wr, 0.05)] {
            walls.push(block([x - width, wb, z1 + 0.03], [x + width, wt, z1 + 0.08], plaster));
        }
        for (y, height) in [(wb, 0.05), (1.7, 0.03), (wt, 0.05)] {
            walls.push(block([wl, y - height, z1 + 0.03], [wr, y + height, z1 + 0.08], plaster));
        }
        walls.push(block([wl - 0.1, wb - 0.06, z1 - 0.18], [wr + 0.1, wb - 0.02, z1], plaster));
        walls.push(block([0.0, 1.25, z1 - 0.02], [1.05, 1.95, z1], Surface::Chart));

        let mut table = vec![
            // A table with a lamp, a chrome ball and fruit.
            block([-0.35, 0.70, 2.95], [1.15, 0.75, 3.75], Surface::Matt(ORANGE, 0.75)),
            block([0.54, 0.75, 3.27], [0.70, 0.77, 3.43], matt(BLACK)),
            block([0.612, 0.77, 3.342], [0.628, 1.18, 3.358], matt(BLACK)),
            ball([-0.05, 0.90, 3.35], 0.15, Surface::Mirror),
            ball([0.28, 0.81, 3.15], 0.06, matt(YELLOW)),
            ball([0.40, 0.815, 3.24], 0.065, matt(RED)),
            ball([0.95, 0.83, 3.25], 0.08, matt(GREEN)),
        ];
        let furniture = vec![
            // A chest in the dark corner, and balls on the floor.
            block([-2.6, 0.0, 2.0], [-1.95, 0.8, 3.6], matt(BROWN)),
            block([-2.55, 0.8, 2.2], [-2.1, 1.15, 2.6], matt(BLACK)),
            ball([-1.05, 0.22, 2.55], 0.22, matt(BLUE)),
            ball([1.75, 0.3, 2.9], 0.3, matt(WHITE)),
        ];
        for (x, z) in [(-0.30, 3.0), (1.06, 3.0), (-0.30, 3.66), (1.06, 3.66)] {
            table.push(block([x, 0.0, z], [x + 0.05, 0.70, z + 0.05], Surface::Matt(ORANGE, 0.75)));
        }
        walls.push(ball(BULB, BULB_RADIUS, Surface::Bulb));
        Self { furniture, table, walls }
    }

    /// The light along a viewing ray. `part` in 0..9 selects one ninth of the samples of the sky; all parts
    /// together give the total.
    pub(super) fn seen(&self, origin: Vec3, direction: Vec3, part: usize) -> Shade {
        let (mut origin, mut direction, mut dimmed) = (origin, direction, 1.0);
        loop {
            let near_table = meets(TABLE_BOUNDS[0], TABLE_BOUNDS[1], origin, direction);
            let table = self.table.iter().take(if near_table { self.table.len() } else { 0 });
            let all = self.walls.iter().chain(&self.furniture).chain(table);
            let hits = all.filter_map(|(s, surface)| s.hit(origin, direction).map(|h| (h, *surface)));
            let Some(((t, normal), surface)) = hits.min_by(|a, b| a.0.0.total_cmp(&b.0.0)) else {
                return dim(outside(unit(direction)), dimmed);
            };
            let point = add(origin, scale(direction, t));
            let (reflectance, factor) = match surface {
                Surface::Mirror if dimmed == 1.0 => {
                    dimmed = 0.85;
                    direction = sub(direction, scale(normal, 2.0 * dot(normal, direction)));
                    origin = point;
                    continue;
                }
                Surface::Mirror => (WHITE, 0.1),
                Surface::Bulb => {
                    let cd_m2 = BULB_CD / (std::f64::consts::PI * BULB_RADIUS * BULB_RADIUS) / GREYS[0];
                    return dim(Shade { reflectance: WHITE, daylight: 0.0, lamplight: cd_m2 }, dimmed);
                }
                Surface::Matt(reflectance, factor) => (reflectance, factor),
                Surface::Boards => boards(point),
                Surface::Chart => chart(point),
            };
            let (daylight, lamplight) = self.light(point, normal, part);
            return dim(
                Shade { reflectance, daylight: factor * daylight, lamplight: factor * lamplight },
                dimmed,
            );
        }
    }

    /// Daylight and lamplight at a surface point.
    fn light(&self, point: Vec3, normal: Vec3, part: usize) -> (f64, f64) {
        let pi = std::f64::consts::PI;
        if point[2] > HIGH[2] + WALL {
            // The corridor receives only light that enters through the door and is reflected.
            let depth = point[2] - HIGH[2] - WALL;
            let facing = 0.55 - 0.45 * normal[2];
            return (9.0 * (-1.9 * depth).exp() * facing, 0.0);
        }
        let mut daylight = 28.0 * self.openness(point, normal, part);
        let mut lamplight = 0.12 * daylight;
        // The sky through the window: 2 × 2 of 6 × 6 samples.
        let [x0, x1, y0, y1] = WINDOW;
        let area = (x1 - x0) * (y1 - y0);
        for i in 0..4 {
            let (u, v) = (part % 3 * 2 + i % 2, part / 3 * 2 + i / 2);
            let share = |k: usize| (k as f64 + 0.5) / 6.0;
            let to = sub([x0 + share(u) * (x1 - x0), y0 + share(v) * (y1 - y0), HIGH[2]], point);
            let square = dot(to, to);
            let form = dot(to, normal).max(0.0) * to[2].max(0.0) / (square * square);
            if form > 0.0 && !self.shadowed(point, to) {
                daylight += SKY_CD_M2 * area / 4.0 * form / pi;
            }
        }
        let to_sun = unit(TO_SUN);
        let facing = dot(to_sun, normal);
        if facing > 0.0 && sun_enters(point, to_sun) && !self.shadowed(point, scale(to_sun, 20.0)) {
            daylight += SUN_LUX * facing / pi;
        }
        let to = sub(BULB, point);
        let square = dot(to, to);
        let facing = dot(to, normal) / square.sqrt();
        if facing > 0.0 && !self.shadowed(point, to) {
            lamplight += BULB_CD * facing / square.max(BULB_RADIUS * BULB_RADIUS) / pi;
        }
        (daylight, lamplight)
    }

    fn shadowed(&self, from: Vec3, to: Vec3) -> bool {
        let hit = |(s, _): &(Shape, Surface)| s.hit(from, to).is_some_and(|(t, _)| t < 1.0);
        self.furniture.iter().any(hit)
            || meets(TABLE_BOUNDS[0], TABLE_BOUNDS[1], from, to) && self.table.iter().any(hit)
    }

    /// Fraction of the light from the walls that arrives, 0 to 1. It is lower in corners, and under and
    /// behind furniture.
    fn openness(&self, point: Vec3, normal: Vec3, part: usize) -> f64 {
        let corner: f64 = (0..3)
            .flat_map(|i| [point[i] - LOW[i], HIGH[i] - point[i]].map(|d| (i, d)))
            .filter(|&(i, _)| normal[i].abs() < 0.9)
            .map(|(_, d)| 1.0 - 0.45 * (-d.max(0.0) / 0.35).exp())
            .product();
        // Two of six directions per part.
        let sides = [
            [0.0, 0.0, 0.0],
            [0.7, 0.0, 0.0],
            [-0.7, 0.0, 0.0],
            [0.0, 0.7, 0.0],
            [0.0, 0.0, 0.7],
            [0.0, 0.0, -0.7],
        ];
        let sides = [sides[part % 3], sides[3 + part % 3]];
        let open = sides.iter().filter(|&&s| !self.shadowed(point, scale(unit(add(normal, s)), 0.9))).count();
        corner * (0.06 + 0.94 * open as f64 / 2.0)
    }
}

fn dim(shade: Shade, factor: f64) -> Shade {
    Shade { daylight: shade.daylight * factor, lamplight: shade.lamplight * factor, ..shade }
}

/// Whether the line from a point to the sun passes through the window panes.
fn sun_enters(point: Vec3, to_sun: Vec3) -> bool {
    let at = |z: f64| add(point, scale(to_sun, (z - point[2]) / to_sun[2]));
    let [x0, x1, y0, y1] = WINDOW;
    let within = |p: Vec3| p[0] > x0 + 0.05 && p[0] < x1 - 0.05 && p[1] > y0 + 0.05 && p[1] < y1 - 0.05;
    let frame = at(HIGH[2] + 0.05);
    let bars = (frame[0] - (x0 + x1) / 2.0).abs() < 0.03 || (frame[1] - 1.7).abs() < 0.03;
    point[2] < HIGH[2] && within(at(HIGH[2])) && within(at(HIGH[2] + WALL)) && !bars
}

/// Sky above hills.
fn outside(direction: Vec3) -> Shade {
    let (x, y) = (direction[0] / direction[2].max(0.1), direction[1] / direction[2].max(0.1));
    let far = 0.10 + 0.03 * (7.0 * x).sin() + 0.015 * (17.0 * x + 1.0).sin();
    let near = 0.05 * (3.1 * x + 2.0).sin();
    let (reflectance, daylight) = if y < near {
        (FOLIAGE, 9_000.0)
    } else if y < far {
        (GREEN, 12_000.0)
    } else {
        // A clear sky is brighter towards the horizon.
        (SKY, 13_000.0 + 14_000.0 * (-(y - far) / 0.12).exp())
    };
    Shade { reflectance, daylight, lamplight: 0.0 }
}

fn boards(point: Vec3) -> (usize, f64) {
    let board = (point[0] / 0.16).floor();
    let gap = point[0] / 0.16 - board < 0.04;
    let tone = (board * 2.399).sin() * 0.18 + 1.0 + 0.04 * (point[2] * 31.0 + board).sin();
    (BROWN, if gap { 0.5 } else { 1.6 * tone })
}

/// Six by four patches on black.
fn chart(point: Vec3) -> (usize, f64) {
    let (u, v) = ((point[0] - 0.03) / 0.165, (1.92 - point[1]) / 0.16);
    let (col, row) = (u.floor(), v.floor());
    let gap = u - col > 0.9 || v - row > 0.9;
    let inside = (0.0..macbeth::COLS as f64).contains(&col) && (0.0..macbeth::ROWS as f64).contains(&row);
    if gap || !inside { (BLACK, 1.5) } else { (row as usize * macbeth::COLS + col as usize, 1.0) }
}
