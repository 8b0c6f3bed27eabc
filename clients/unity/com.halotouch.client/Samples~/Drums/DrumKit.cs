using HaloTouch;
using UnityEngine;

/// <summary>
/// Drum pads on the surface: a touch sounds the pad under it, its speed is the loudness, and the height
/// of the other fingers bends the pitch. Add it to the object of a Halo Surface and press Play.
/// </summary>
[RequireComponent(typeof(HaloSurface))]
public sealed class DrumKit : MonoBehaviour
{
    const int SampleRate = 44100;
    const float LoudestMmS = 800;
    const float MediumMmS = 200; // where the speed is unknown
    const float BendMm = 100;

    [SerializeField]
    [Tooltip("Frequencies of the pads in Hz, from left to right")]
    float[] frequenciesHz = { 90, 160, 240, 400 };

    AudioSource[] _pads;
    HaloSurface _surface;
    HaloReceiver _receiver;

    void OnEnable()
    {
        _surface = GetComponent<HaloSurface>();
        _receiver = _surface.Receiver;
        if (_receiver == null) return;
        if (_pads == null) Build();
        _receiver.Down += Hit;
        _receiver.FrameReceived += Bend;
    }

    void OnDisable()
    {
        if (_receiver == null) return;
        _receiver.Down -= Hit;
        _receiver.FrameReceived -= Bend;
    }

    void Build()
    {
        _pads = new AudioSource[frequenciesHz.Length];
        var size = _surface.SizeMm;
        for (var i = 0; i < _pads.Length; i++)
        {
            var pad = GameObject.CreatePrimitive(PrimitiveType.Cube);
            pad.transform.SetParent(transform);
            pad.transform.position = _surface.ToWorld((i + 0.5f) * size.x / _pads.Length, size.y / 2, -5);
            pad.transform.rotation = transform.rotation;
            pad.transform.localScale = new Vector3(0.9f * size.x / _pads.Length, 10, 0.9f * size.y) / 1000;
            pad.GetComponent<Renderer>().material.color = Color.HSVToRGB(i / (float)_pads.Length, 0.7f, 0.9f);
            _pads[i] = pad.AddComponent<AudioSource>();
            _pads[i].clip = Drum(frequenciesHz[i]);
        }
    }

    // A sine that falls in pitch and fades.
    static AudioClip Drum(float frequencyHz)
    {
        var samples = new float[SampleRate / 2];
        for (var i = 0; i < samples.Length; i++)
        {
            var time = i / (float)SampleRate;
            var phase = 2 * Mathf.PI * frequencyHz * (time + 0.02f * (1 - Mathf.Exp(-time * 30)));
            samples[i] = Mathf.Sin(phase) * Mathf.Exp(-time * 9);
        }
        var clip = AudioClip.Create("drum " + frequencyHz, samples.Length, 1, SampleRate, false);
        clip.SetData(samples, 0);
        return clip;
    }

    void Hit(HaloFrame frame, HaloContact contact)
    {
        var index = Mathf.Clamp((int)(contact.U * _pads.Length), 0, _pads.Length - 1);
        var speed = contact.StrikeMmS < 0 ? MediumMmS : contact.StrikeMmS;
        _pads[index].PlayOneShot(_pads[index].clip, Mathf.Clamp01(speed / LoudestMmS));
    }

    void Bend(HaloReceiver receiver, HaloFrame frame)
    {
        var pitch = 1f;
        foreach (var pointer in frame.Pointers)
            if (!pointer.IsTouching) pitch = Mathf.Lerp(1, 2, pointer.HoverMm / BendMm);
        foreach (var pad in _pads) pad.pitch = pitch;
    }
}
