using System;
using UnityEngine;

namespace HaloTouch
{
    // The handlers of one event. A handler that raises is logged and hides nothing from the others: a
    // touchscreen must not miss the end of a touch because of it. A call allocates nothing.
    sealed class Handlers<TFirst, TSecond>
    {
        Action<TFirst, TSecond>[] _all = new Action<TFirst, TSecond>[0];

        public bool IsEmpty => _all.Length == 0;

        // A new array each time: handlers can be added and removed during a call.
        public void Add(Action<TFirst, TSecond> handler)
        {
            var more = new Action<TFirst, TSecond>[_all.Length + 1];
            _all.CopyTo(more, 0);
            more[_all.Length] = handler;
            _all = more;
        }

        public void Remove(Action<TFirst, TSecond> handler)
        {
            var index = Array.LastIndexOf(_all, handler);
            if (index < 0) return;
            var fewer = new Action<TFirst, TSecond>[_all.Length - 1];
            Array.Copy(_all, fewer, index);
            Array.Copy(_all, index + 1, fewer, index, fewer.Length - index);
            _all = fewer;
        }

        public void Call(TFirst first, TSecond second, UnityEngine.Object context)
        {
            foreach (var handler in _all)
            {
                try
                {
                    handler(first, second);
                }
                catch (Exception error)
                {
                    Debug.LogException(error, context);
                }
            }
        }
    }
}
