// Pegs on which a fingertip rests at a known height: for `halo calibrate touch --hover-mm 10
// --subtle-mm 1`, and for `halo evaluate --live`.
//
//   openscad -o spacers.stl spacers.scad                         all
//   openscad -D 'heights=[10]' -o spacer-10.stl spacers.scad     one
//
// A peg must be narrower than the fingertip, so that the finger hides it from the camera: what shows
// beside the finger is taken for hand, and hides the halo that is to be measured.
//
// These were never printed yet. Measure each, and say what it measures. Where it may slip, hold it
// with a dot of thin tape on its foot.

heights = [1, 5, 7, 10, 12, 15]; // mm
width = 7;                       // mm; 6 to 8: fingertips are 12 to 18
edge = 0.3;                      // mm cut off the foot, where a first layer swells

module peg(height) {
    cylinder(d1 = width - 2 * edge, d2 = width, h = edge, $fn = 64);
    translate([0, 0, edge]) cylinder(d = width, h = height - edge, $fn = 64);
}

for (n = [0 : len(heights) - 1]) translate([n * (width + 5), 0, 0]) peg(heights[n]);
