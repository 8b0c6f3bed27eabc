// A circle for each finger: blue and larger in the air, orange and larger with pressure in touch,
// and a flash for each hit. First start: halo serve --osc 127.0.0.1:7000/flat

HaloFlat halo;
int[] seenHits = new int[HaloFlat.SLOTS];
float[] flash = new float[HaloFlat.SLOTS];

void setup() {
  size(900, 600);
  halo = new HaloFlat(7000);
}

void draw() {
  background(16, 20, 24);
  noStroke();
  int count = 0;
  for (int n = 0; n < HaloFlat.SLOTS; n++) {
    HaloFlat.Slot slot = halo.slots[n];
    if (slot.hits > seenHits[n]) flash[n] = 1;
    seenHits[n] = slot.hits;
    flash[n] *= 0.9;
    if (!slot.present()) continue;
    count++;
    float x = slot.u * width;
    float y = slot.v * height;
    fill(255, 255 * flash[n]);
    ellipse(x, y, 160, 160);
    if (slot.touch) fill(255, 180, 84);
    else fill(89, 194, 255, 120);
    float size = slot.touch ? 24 + 60 * slot.pressure : 30 + 2 * min(slot.hover, 60);
    ellipse(x, y, size, size);
  }
  fill(223, 230, 238);
  text("fingers: " + count, 16, 24);
}
