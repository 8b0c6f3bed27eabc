using System;
using UnityEngine;
using UnityEngine.Events;

namespace HaloTouch
{
    /// <summary>Fingers as events of the inspector, without a script.</summary>
    [AddComponentMenu("Halo Touch/Halo Pointer Events")]
    public sealed class HaloPointerEvents : MonoBehaviour
    {
        /// <summary>An event with a world position in metres.</summary>
        [Serializable]
        public sealed class PositionEvent : UnityEvent<Vector3>
        {
        }

        /// <summary>An event with a number.</summary>
        [Serializable]
        public sealed class NumberEvent : UnityEvent<float>
        {
        }

        /// <summary>An event with all values of a finger.</summary>
        [Serializable]
        public sealed class PointerEvent : UnityEvent<HaloPointer>
        {
        }

        [SerializeField]
        HaloSurface surface = null;

        [SerializeField]
        [Tooltip("Only the finger of this slot, 0 to 9; -1: each finger")]
        int slot = -1;

        [SerializeField]
        [Tooltip("A touch began: world position in metres")]
        PositionEvent down = new PositionEvent();

        [SerializeField]
        [Tooltip("A touch began: its speed in mm/s; -1 if it is unknown")]
        NumberEvent strike = new NumberEvent();

        [SerializeField]
        [Tooltip("A touch goes on, once a frame: world position in metres")]
        PositionEvent move = new PositionEvent();

        [SerializeField]
        [Tooltip("A touch goes on, once a frame: 1 is the calibrated medium press")]
        NumberEvent pressure = new NumberEvent();

        [SerializeField]
        [Tooltip("A touch ended: world position in metres")]
        PositionEvent up = new PositionEvent();

        [SerializeField]
        [Tooltip("A finger is above the surface, once a frame: its height in mm")]
        NumberEvent hover = new NumberEvent();

        [SerializeField]
        [Tooltip("Each finger, once a frame, with all values")]
        PointerEvent pointer = new PointerEvent();

        HaloReceiver _receiver;

        /// <summary>A touch began: world position in metres.</summary>
        public PositionEvent OnDown => down;

        /// <summary>A touch began: its speed in mm/s, -1 if it is unknown.</summary>
        public NumberEvent OnStrike => strike;

        /// <summary>A touch goes on, once a frame: world position in metres.</summary>
        public PositionEvent OnMove => move;

        /// <summary>A touch goes on, once a frame: 1 is the calibrated medium press.</summary>
        public NumberEvent OnPressure => pressure;

        /// <summary>A touch ended: world position in metres.</summary>
        public PositionEvent OnUp => up;

        /// <summary>A finger is above the surface, once a frame: its height in mm.</summary>
        public NumberEvent OnHover => hover;

        /// <summary>Each finger, once a frame.</summary>
        public PointerEvent OnPointer => pointer;

        void OnEnable()
        {
            _receiver = surface == null ? null : surface.Receiver;
            if (_receiver == null) return;
            _receiver.FrameReceived += Report;
            _receiver.Down += ReportDown;
            _receiver.Moved += ReportMove;
            _receiver.Up += ReportUp;
        }

        void OnDisable()
        {
            if (_receiver == null) return;
            _receiver.FrameReceived -= Report;
            _receiver.Down -= ReportDown;
            _receiver.Moved -= ReportMove;
            _receiver.Up -= ReportUp;
            _receiver = null;
        }

        bool IsOurs(int number) => slot < 0 || slot == number;

        void Report(HaloReceiver receiver, HaloFrame frame)
        {
            foreach (var each in frame.Pointers)
            {
                if (!IsOurs(each.Slot)) continue;
                pointer.Invoke(each);
                if (!each.IsTouching) hover.Invoke(each.HoverMm);
            }
        }

        void ReportDown(HaloFrame frame, HaloContact contact)
        {
            if (!IsOurs(contact.Slot)) return;
            down.Invoke(surface.ToWorld(contact));
            strike.Invoke(contact.StrikeMmS);
        }

        void ReportMove(HaloFrame frame, HaloPointer each)
        {
            if (!IsOurs(each.Slot)) return;
            move.Invoke(surface.ToWorld(each));
            pressure.Invoke(each.Pressure);
        }

        void ReportUp(HaloFrame frame, HaloContact contact)
        {
            if (IsOurs(contact.Slot)) up.Invoke(surface.ToWorld(contact));
        }
    }
}
