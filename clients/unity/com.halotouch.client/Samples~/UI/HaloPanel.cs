using HaloTouch;
using UnityEngine;
using UnityEngine.UIElements;

/// <summary>
/// A panel of UI Toolkit that fingers on the table use like a touchscreen. Add it to an object with a UI
/// Document, and a Halo Touchscreen to the scene.
/// </summary>
[RequireComponent(typeof(UIDocument))]
public sealed class HaloPanel : MonoBehaviour
{
    [SerializeField]
    HaloReceiver receiver = null;

    Label _state;
    int _count;

    void OnEnable()
    {
        var root = GetComponent<UIDocument>().rootVisualElement;
        root.Clear();
        var button = new Button(Count) { text = "Tap me" };
        button.style.width = 300;
        button.style.height = 120;
        var slider = new Slider("Level", 0, 100);
        slider.RegisterValueChangedCallback(change => _state.text = "level " + change.newValue.ToString("0"));
        _state = new Label("no tap yet");
        root.Add(button);
        root.Add(slider);
        root.Add(_state);
    }

    void Count()
    {
        _count++;
        _state.text = _count + " taps";
    }

    void Update()
    {
        if (receiver != null && !receiver.IsConnected) _state.text = receiver.Status;
    }
}
