/* Drops a file on a window, as a file manager does (XDND, version 5): drop_file WINDOW PATH.  Exit code 0 when the
 * window has taken it. */
#include <X11/Xatom.h>
#include <X11/Xlib.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { VERSION = 5, MOST_WAITS = 500 };

typedef struct drag {
    Display *display;
    Window source, target;
    Atom selection, uri_list;
    char uri[4096];
} drag;

static Atom atom(const drag *d, const char *name) {
    return XInternAtom(d->display, name, False);
}

static void tell(const drag *d, const char *message, long first, long second, long third, long fourth) {
    XEvent event;
    memset(&event, 0, sizeof event);
    event.xclient.type = ClientMessage;
    event.xclient.window = d->target;
    event.xclient.message_type = atom(d, message);
    event.xclient.format = 32;
    event.xclient.data.l[0] = (long)d->source;
    event.xclient.data.l[1] = first;
    event.xclient.data.l[2] = second;
    event.xclient.data.l[3] = third;
    event.xclient.data.l[4] = fourth;
    XSendEvent(d->display, d->target, False, NoEventMask, &event);
    XFlush(d->display);
}

/* The window asks for what is dropped. */
static void answer(const drag *d, const XSelectionRequestEvent *request) {
    XEvent event;
    memset(&event, 0, sizeof event);
    XChangeProperty(d->display, request->requestor, request->property, d->uri_list, 8, PropModeReplace,
                    (const unsigned char *)d->uri, (int)strlen(d->uri));
    event.xselection.type = SelectionNotify;
    event.xselection.requestor = request->requestor;
    event.xselection.selection = request->selection;
    event.xselection.target = request->target;
    event.xselection.property = request->property;
    event.xselection.time = request->time;
    XSendEvent(d->display, request->requestor, False, NoEventMask, &event);
    XFlush(d->display);
}

/* Handles events until the window sends `message`.  0, or -1 when it does not. */
static int await(const drag *d, const char *message) {
    const Atom wanted = atom(d, message);
    const struct timespec moment = {0, 10 * 1000 * 1000};
    for (int waits = 0; waits < MOST_WAITS; waits++, nanosleep(&moment, NULL))
        while (XPending(d->display) > 0) {
            XEvent event;
            XNextEvent(d->display, &event);
            if (event.type == SelectionRequest)
                answer(d, &event.xselectionrequest);
            if (event.type == ClientMessage && event.xclient.message_type == wanted)
                return 0;
        }
    fprintf(stderr, "drop_file: no %s from the window\n", message);
    return -1;
}

int main(int argc, char **argv) {
    drag d;
    if (argc != 3) {
        fprintf(stderr, "usage: drop_file WINDOW PATH\n");
        return 2;
    }
    memset(&d, 0, sizeof d);
    d.display = XOpenDisplay(NULL);
    if (!d.display) {
        fprintf(stderr, "drop_file: no display\n");
        return 1;
    }
    d.target = strtoul(argv[1], NULL, 0);
    d.source = XCreateSimpleWindow(d.display, DefaultRootWindow(d.display), 0, 0, 1, 1, 0, 0, 0);
    d.selection = atom(&d, "XdndSelection");
    d.uri_list = atom(&d, "text/uri-list");
    snprintf(d.uri, sizeof d.uri, "file://%s\r\n", argv[2]);
    XSetSelectionOwner(d.display, d.selection, d.source, CurrentTime);
    tell(&d, "XdndEnter", (long)VERSION << 24, (long)d.uri_list, 0, 0);
    tell(&d, "XdndPosition", 0, 100 << 16 | 100, CurrentTime, (long)atom(&d, "XdndActionCopy"));
    int failed = await(&d, "XdndStatus");
    if (!failed) {
        tell(&d, "XdndDrop", 0, CurrentTime, 0, 0);
        failed = await(&d, "XdndFinished");
    }
    XCloseDisplay(d.display);
    return failed ? 1 : 0;
}
