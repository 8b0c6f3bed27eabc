// The wedge on which a calibrating finger rests, so that it keeps one pitch while it is drawn over
// the surface: 45 degrees for the sweep, all five for a base model (`halo calibrate pilot`).
//
//   openscad -D angle=45 -o wedge-45.stl wedge.scad        one
//   openscad -D 'angle="all"' -o wedges.stl wedge.scad     15, 30, 45, 60 and 75 degrees, side by side
//
// Print it lying on its side, without supports, in a light and matt colour: what shines or is black
// has no depth. The finger lies in the groove, its tip beyond the sharp end, on the surface.

angle = "all";
/* [Finger] */
finger = 18;   // mm, the widest finger that the groove takes; adults' index fingers are 14 to 18
rest = 32;     // mm of the finger that rest on it: the two joints behind the pad
groove = 2;    // mm, how deep the finger lies
/* [Body] */
wall = 2;      // mm beside the groove
blunt = 0.8;   // mm, the sharp end's height: thinner ones break

width = finger + 2 * wall;

module wedge(pitch) {
    // Steep ones would be needles: all keep 18 mm of foot, and so stand.
    foot = max(rest * cos(pitch), 18);
    top = blunt + rest * sin(pitch);
    run = rest * cos(pitch);
    difference() {
        rotate([90, 0, 0])
            linear_extrude(height = width, center = true)
                polygon([[0, 0], [foot, 0], [foot, top], [run, top], [0, blunt]]);
        // The groove: a cylinder as thick as the finger along the slope, sunk by `groove`.
        translate([0, 0, blunt])
            rotate([0, 90 - pitch, 0])
                translate([-(finger / 2 - groove), 0, -5])
                    cylinder(d = finger, h = rest + 10, $fn = 96);
        // Which one it is, on its side.
        translate([foot - 1.5, -width / 2 + 0.4, 1.5])
            rotate([90, 0, 0])
                linear_extrude(height = 1)
                    text(str(pitch), size = 4, halign = "right");
    }
}

if (angle == "all")
    for (n = [0 : 4]) translate([0, n * (width + 6), 0]) wedge(15 * (n + 1));
else
    wedge(angle);
