using System.Collections.Generic;
using HaloTouch;
using UnityEngine;

/// <summary>
/// Each touch draws a line on the surface; pressure makes it wider. Add it to the object of a Halo
/// Surface and press Play.
/// </summary>
[RequireComponent(typeof(HaloSurface))]
public sealed class PaintCanvas : MonoBehaviour
{
    const float ThinM = 0.002f;
    const float WideM = 0.012f; // at the medium press
    const float AboveMm = 0.5f; // so that lines do not lie in the table's plane
    const int MaxStrokes = 200;

    [SerializeField]
    Material material = null;

    readonly Dictionary<int, LineRenderer> _open = new Dictionary<int, LineRenderer>(); // by finger
    readonly Queue<LineRenderer> _strokes = new Queue<LineRenderer>();
    HaloSurface _surface;
    HaloReceiver _receiver;

    void OnEnable()
    {
        _surface = GetComponent<HaloSurface>();
        _receiver = _surface.Receiver;
        if (_receiver == null) return;
        _receiver.Down += Begin;
        _receiver.Moved += Draw;
        _receiver.Up += End;
    }

    void OnDisable()
    {
        if (_receiver == null) return;
        _receiver.Down -= Begin;
        _receiver.Moved -= Draw;
        _receiver.Up -= End;
    }

    void Begin(HaloFrame frame, HaloContact contact)
    {
        var stroke = new GameObject("stroke").AddComponent<LineRenderer>();
        stroke.transform.SetParent(transform);
        stroke.material = material != null ? material : new Material(Shader.Find("Sprites/Default"));
        stroke.startColor = stroke.endColor = Color.HSVToRGB(contact.Slot % 10 / 10f, 0.8f, 1);
        stroke.positionCount = 0;
        stroke.widthMultiplier = ThinM;
        _open[contact.Id] = stroke;
        _strokes.Enqueue(stroke);
        if (_strokes.Count > MaxStrokes) Destroy(_strokes.Dequeue().gameObject);
    }

    void Draw(HaloFrame frame, HaloPointer pointer)
    {
        if (!_open.TryGetValue(pointer.Id, out var stroke) || stroke == null) return;
        stroke.positionCount++;
        stroke.SetPosition(stroke.positionCount - 1, _surface.ToWorld(pointer.XMm, pointer.YMm, AboveMm));
        var width = Mathf.Lerp(ThinM, WideM, pointer.Pressure);
        stroke.widthMultiplier = Mathf.Max(stroke.widthMultiplier, width);
    }

    void End(HaloFrame frame, HaloContact contact)
    {
        _open.Remove(contact.Id);
    }
}
