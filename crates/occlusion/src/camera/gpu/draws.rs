//! From a list of objects to draw calls.

use super::scene::Drawn;
use super::settings::Drawing;
use std::ops::Range;

/// One draw call: vertices of the templates of a range of the list's objects.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Call {
    pub masked: bool,
    pub vertices: Range<u32>,
    /// Places in [`Plan::list`].
    pub instances: Range<u32>,
}

/// What is drawn between two batches; kept between frames.
#[derive(Debug, Default)]
pub(super) struct Plan {
    /// Objects in the order in which they are drawn.
    pub list: Vec<u32>,
    pub calls: Vec<Call>,
    keys: Vec<(bool, u32, u32)>,
}

impl Plan {
    /// Turns the list as it was given into calls; reorders it for [`Drawing::Instanced`].
    pub fn make(&mut self, objects: &[Drawn], drawing: Drawing) {
        self.calls.clear();
        if drawing == Drawing::Instanced {
            self.by_template(objects);
        }
        for (place, &object) in (0..).zip(&self.list) {
            let Drawn { template, triangles, masked } = objects[object as usize];
            let vertices = 0..3 * triangles;
            let instances = place..place + 1;
            match drawing {
                _ if triangles == 0 => {}
                Drawing::PerObject => self.calls.push(Call { masked, vertices, instances }),
                Drawing::PerQuad => {
                    let quads = (0..vertices.end).step_by(6);
                    self.calls.extend(quads.map(|first| Call {
                        masked,
                        vertices: first..(first + 6).min(vertices.end),
                        instances: instances.clone(),
                    }));
                }
                Drawing::Instanced => {
                    let before = place.checked_sub(1).map(|p| self.list[p as usize]);
                    let same = before.is_some_and(|b| objects[b as usize].template == template);
                    match self.calls.last_mut() {
                        Some(call) if same => call.instances.end = instances.end,
                        _ => self.calls.push(Call { masked, vertices, instances }),
                    }
                }
            }
        }
    }

    pub fn clear(&mut self) {
        self.list.clear();
        self.calls.clear();
    }

    /// Puts objects of a template side by side, in the order they were given; those with a mask
    /// last.
    fn by_template(&mut self, objects: &[Drawn]) {
        self.keys.clear();
        self.keys.extend((0..).zip(&self.list).map(|(place, &object)| {
            let Drawn { template, masked, .. } = objects[object as usize];
            (masked, template, place)
        }));
        self.keys.sort_unstable();
        // Places become objects before the list is overwritten.
        for key in &mut self.keys {
            key.2 = self.list[key.2 as usize];
        }
        for (object, key) in self.list.iter_mut().zip(&self.keys) {
            *object = key.2;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(template: u32, triangles: u32, masked: bool) -> Drawn {
        Drawn { template, triangles, masked }
    }

    fn plan(objects: &[Drawn], list: &[u32], drawing: Drawing) -> Plan {
        let mut plan = Plan { list: list.to_vec(), ..Plan::default() };
        plan.make(objects, drawing);
        plan
    }

    #[test]
    fn each_way_of_drawing_makes_its_calls() {
        let objects =
            [drawn(1, 2, false), drawn(0, 5, true), drawn(1, 2, false), drawn(2, 0, false)];
        let list = [0, 1, 3, 2];
        let call = |masked, vertices, instances| Call { masked, vertices, instances };

        let each = plan(&objects, &list, Drawing::PerObject);
        assert_eq!(each.list, list);
        let calls = [call(false, 0..6, 0..1), call(true, 0..15, 1..2), call(false, 0..6, 3..4)];
        assert_eq!(each.calls, calls);

        let quads = plan(&objects, &list, Drawing::PerQuad);
        let calls = [
            call(false, 0..6, 0..1),
            call(true, 0..6, 1..2),
            call(true, 6..12, 1..2),
            call(true, 12..15, 1..2),
            call(false, 0..6, 3..4),
        ];
        assert_eq!(quads.calls, calls);

        let instanced = plan(&objects, &list, Drawing::Instanced);
        assert_eq!(instanced.list, [0, 2, 3, 1]);
        assert_eq!(instanced.calls, [call(false, 0..6, 0..2), call(true, 0..15, 3..4)]);
    }

    #[test]
    fn a_plan_made_again_forgets_the_last_one() {
        let objects = [drawn(0, 1, false), drawn(0, 1, false)];
        let mut plan = plan(&objects, &[1, 0, 1], Drawing::Instanced);
        assert_eq!(plan.list, [1, 0, 1]);
        assert_eq!(plan.calls.len(), 1);
        plan.clear();
        plan.list.push(0);
        plan.make(&objects, Drawing::Instanced);
        assert_eq!(plan.calls, [Call { masked: false, vertices: 0..3, instances: 0..1 }]);
    }
}
