/** Signatures of Processing that the sketch uses, written by hand from its reference. Draws nothing. */
public class PApplet {
  public int width = 900, height = 600;

  public void size(int width, int height) {}

  public void background(float red, float green, float blue) {}

  public void noStroke() {}

  public void fill(float red, float green, float blue) {}

  public void fill(float red, float green, float blue, float alpha) {}

  public void fill(float grey, float alpha) {}

  public void ellipse(float x, float y, float width, float height) {}

  public void text(String words, float x, float y) {}

  public static float min(float a, float b) {
    return Math.min(a, b);
  }
}
