import java.nio.ByteBuffer;
import java.util.HexFormat;
import java.util.Scanner;

/** Reads datagrams in hex, one a line, and prints all slots after each. */
public class ReadFlat {
  public static void main(String[] arguments) {
    HaloFlat halo = new HaloFlat();
    Scanner lines = new Scanner(System.in);
    while (lines.hasNextLine()) {
      halo.receive(ByteBuffer.wrap(HexFormat.of().parseHex(lines.nextLine())));
      StringBuilder text = new StringBuilder();
      for (HaloFlat.Slot slot : halo.slots) {
        text.append(String.format("%b %s %s %s %s %s %s %d;", slot.touch, slot.u, slot.v, slot.xMm,
            slot.hover, slot.pressure, slot.forceG, slot.hits));
      }
      System.out.println(text);
    }
  }
}
