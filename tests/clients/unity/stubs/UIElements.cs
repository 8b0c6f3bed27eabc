// Signatures of UI Toolkit, written by hand from Unity's public scripting reference. See UnityEngine.cs.
using System;

namespace UnityEngine.UIElements
{
    public struct StyleLength
    {
        public static implicit operator StyleLength(float v) => throw null;
    }

    public interface IStyle
    {
        StyleLength width { get; set; }
        StyleLength height { get; set; }
    }

    public class VisualElement
    {
        public IStyle style { get; }
        public void Add(VisualElement child) => throw null;
        public void Clear() => throw null;
    }

    public class TextElement : VisualElement
    {
        public virtual string text { get; set; }
    }

    public class Label : TextElement
    {
        public Label(string text) => throw null;
    }

    public class Button : TextElement
    {
        public Button(Action clickEvent) => throw null;
    }

    public class ChangeEvent<T>
    {
        public T newValue { get; }
    }

    public delegate void EventCallback<in TEventType>(TEventType evt);

    public interface INotifyValueChanged<T>
    {
        T value { get; set; }
    }

    public class Slider : VisualElement, INotifyValueChanged<float>
    {
        public Slider(string label, float start = 0, float end = 10) => throw null;
        public float value { get; set; }
    }

    public static class INotifyValueChangedExtensions
    {
        public static bool RegisterValueChangedCallback<T>(
            this INotifyValueChanged<T> control, EventCallback<ChangeEvent<T>> callback) => throw null;
    }

    public sealed class UIDocument : MonoBehaviour
    {
        public VisualElement rootVisualElement { get; }
    }
}
