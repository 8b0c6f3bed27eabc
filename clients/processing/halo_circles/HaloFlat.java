import java.io.IOException;
import java.net.DatagramPacket;
import java.net.DatagramSocket;
import java.net.SocketException;
import java.net.SocketTimeoutException;
import java.nio.BufferUnderflowException;
import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;

/**
 * The fingers of a halo service, from its format "flat": one number per address, such as
 * /halo/1/table/slot/0/pressure. A thread receives; read `slots` in draw(). Needs no library.
 */
public class HaloFlat {
  /** One finger. A slot without one has touch false and hover -1. */
  public static class Slot {
    public volatile boolean touch;
    public volatile float u, v; // 0 to 1, from left to right and from the far to the near edge
    public volatile float xMm, yMm;
    public volatile float hover = -1; // height in mm, 0 in touch
    public volatile float pressure; // 1 is a medium press
    public volatile float forceG = -1; // grams, -1 if unknown
    public volatile float strike; // mm/s in three frames after a touch, else 0
    public volatile int hits; // touches so far: larger than in the last draw() is a new hit

    public boolean present() {
      return hover >= 0;
    }
  }

  public static final int SLOTS = 10;
  private static final int LOST_MS = 3000;
  private static final String BUNDLE = "#bundle";
  public final Slot[] slots = new Slot[SLOTS];

  /** Without a port: call receive(). */
  public HaloFlat() {
    for (int n = 0; n < SLOTS; n++) slots[n] = new Slot();
  }

  public HaloFlat(int port) {
    this();
    try {
      DatagramSocket socket = new DatagramSocket(port);
      socket.setSoTimeout(LOST_MS);
      Thread thread = new Thread(() -> run(socket), "halo");
      thread.setDaemon(true);
      thread.start();
    } catch (SocketException error) {
      throw new RuntimeException("port " + port + " is in use: close the other program", error);
    }
  }

  private void run(DatagramSocket socket) {
    byte[] buffer = new byte[65536];
    while (true) {
      try {
        DatagramPacket packet = new DatagramPacket(buffer, buffer.length);
        socket.receive(packet);
        receive(ByteBuffer.wrap(buffer, 0, packet.getLength()));
      } catch (SocketTimeoutException silence) {
        clear();
      } catch (IOException error) {
        System.err.println("halo: " + error.getMessage());
      }
    }
  }

  /** Process a datagram: a message, or a bundle of them. What cannot be read is skipped. */
  public void receive(ByteBuffer datagram) {
    try {
      String first = text(datagram.duplicate());
      if (!first.equals(BUNDLE)) {
        message(datagram);
        return;
      }
      datagram.position(datagram.position() + 16); // the name and the time
      while (datagram.hasRemaining()) {
        ByteBuffer element = datagram.slice();
        int size = element.getInt();
        if (size < 0 || size > element.remaining()) return;
        element.limit(4 + size);
        message(element);
        datagram.position(datagram.position() + 4 + size);
      }
    } catch (BufferUnderflowException | IllegalArgumentException malformed) {
      // Any program can send to this port.
    }
  }

  private void message(ByteBuffer raw) {
    String[] parts = text(raw).split("/");
    if (parts.length != 7 || !parts[1].equals("halo") || !parts[2].equals("1")) return;
    if (!parts[4].equals("slot") || !parts[5].matches("[0-9]")) return;
    String type = text(raw);
    if (!type.equals(",f") && !type.equals(",i")) return;
    float value = type.equals(",f") ? raw.getFloat() : raw.getInt();
    if (Float.isFinite(value)) set(slots[Integer.parseInt(parts[5])], parts[6], value);
  }

  private void set(Slot slot, String name, float value) {
    switch (name) {
      case "u": slot.u = value; break;
      case "v": slot.v = value; break;
      case "x_mm": slot.xMm = value; break;
      case "y_mm": slot.yMm = value; break;
      case "pressure": slot.pressure = value; break;
      case "force_g": slot.forceG = value; break;
      case "strike":
        if (value != 0 && slot.strike == 0) slot.hits++;
        slot.strike = value;
        break;
      case "touch":
        slot.touch = value != 0;
        break;
      case "hover":
        slot.hover = value;
        if (value < 0) slot.pressure = slot.strike = 0;
        break;
      default: // id, vx, vy, and what later versions add
    }
  }

  private void clear() {
    for (Slot slot : slots) {
      slot.touch = false;
      slot.hover = -1;
      slot.pressure = slot.strike = 0;
    }
  }

  /** A text ends with a zero and is filled up to a multiple of four bytes. */
  private static String text(ByteBuffer raw) {
    int start = raw.position();
    while (raw.get() != 0) {}
    int length = raw.position() - start - 1;
    byte[] bytes = new byte[length];
    raw.position(start);
    raw.get(bytes);
    raw.position(start + (length / 4 + 1) * 4);
    return new String(bytes, StandardCharsets.US_ASCII);
  }
}
