//! What a scene is about: the box that a camera is to frame.

use glam::Vec3;

/// Lowest and highest corner of a box, world space.
pub(super) type Corners = (Vec3, Vec3);

/// A surface is flat if it is so many times as long as it is thick.
const FLAT: f32 = 20.0;
/// A flat object dwarfs the others if it is so many times as large as the box around them.
const DWARFING: f32 = 8.0;

/// The box around the objects of a scene, without grounds that dwarf the rest.
///
/// A ground plane reaches to the horizon; a camera that has to see all of it sees nothing of what
/// stands on it. It is told by two things together: it is flat, and much larger than all that is
/// not flat. Either alone would be wrong. Floors and walls of rooms are flat too, and a room is
/// many times as large as its lamp; and of many small parts none says how large the whole is.
/// Where everything is flat, everything is framed.
pub(super) fn subject(objects: &[Corners]) -> Option<Corners> {
    let solid = around(objects.iter().filter(|o| !is_flat(o)));
    let is_subject =
        |o: &&Corners| solid.is_none_or(|s| !is_flat(o) || size(o) <= DWARFING * size(&s));
    around(objects.iter().filter(is_subject))
}

fn is_flat((min, max): &Corners) -> bool {
    let sides = *max - *min;
    sides.min_element() * FLAT < sides.max_element()
}

fn size((min, max): &Corners) -> f32 {
    (*max - *min).length()
}

fn around<'a>(boxes: impl Iterator<Item = &'a Corners>) -> Option<Corners> {
    boxes.copied().reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::{Corners, subject};

    fn slab(center: Vec3, sides: Vec3) -> Corners {
        (center - sides / 2.0, center + sides / 2.0)
    }

    #[test]
    fn a_ground_that_dwarfs_the_rest_is_left_out_and_nothing_else() {
        let ball = slab(Vec3::Y, Vec3::splat(1.0));
        let other = slab(Vec3::new(3.0, 1.0, 0.0), Vec3::splat(1.0));
        let both = Some((Vec3::new(-0.5, 0.5, -0.5), Vec3::new(3.5, 1.5, 0.5)));
        let ground = slab(Vec3::ZERO, Vec3::new(80.0, 0.0, 80.0));
        assert_eq!(subject(&[ground, ball, other]), both);
        // A floor is no ground, and the room is no ground for its lamp.
        let floor = slab(Vec3::ZERO, Vec3::new(6.0, 0.0, 6.0));
        assert_ne!(subject(&[floor, ball, other]), both);
        let room = slab(Vec3::ZERO, Vec3::splat(6.0));
        let lamp = slab(Vec3::Y, Vec3::splat(0.05));
        assert_eq!(subject(&[room, lamp]), Some(room));
        // What is all there is.
        assert_eq!(subject(&[ground]), Some(ground));
        assert_eq!(subject(&[]), None);
    }
}
