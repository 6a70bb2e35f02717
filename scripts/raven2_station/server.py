"""HTTP and WebSockets of the station."""

import asyncio
import json
import pathlib
import signal
import ssl

from aiohttp import WSMsgType, web

from . import access, clients, hands
from .finisher import Finisher
from .library import Library
from .records import Records
from .ros_link import RosLink
from .station import Station
from .supervisor import Supervisor

PAGE = pathlib.Path(__file__).resolve().parent / "page"
STATIC = {p.name: kind for suffix, kind in ((".js", "text/javascript"), (".css", "text/css"), (".svg", "image/svg+xml"))
          for p in PAGE.glob(f"*{suffix}")}
LARGEST_MESSAGE = 16 << 10  # [bytes] of a WebSocket message
LARGEST_BODY = 4 << 10      # [bytes] of a login
MOST_CLIENTS = 64
CLOSE_LIMIT = 1.0           # [s] for the pages to answer when the station closes their connections
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; worker-src 'self'; style-src 'self'; "
                               "img-src 'self' blob: data:; connect-src 'self'; media-src 'self'; frame-src 'self'; form-action 'self'; base-uri 'none'; "
                               "frame-ancestors 'self'",
    "X-Content-Type-Options": "nosniff", "Referrer-Policy": "no-referrer", "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-store"}
# A report has its own scripts and styles; the sandbox keeps them away from the station.
REPORT_POLICY = ("sandbox allow-scripts allow-popups; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
                 "img-src data: 'self'; media-src 'self'")

STATION = web.AppKey("station", Station) if hasattr(web, "AppKey") else "station"
ACCESS = "access"
COOKIE = "cookie"
LOCAL = "local"


@web.middleware
async def guard(request, handler):
    """Headers on every answer; names of this computer alone on loopback."""
    if request.app[LOCAL] and not access.is_local_name(request.host):
        request.app[STATION].refused["foreign_host"] += 1
        response = web.Response(status=421, text="Use http://localhost with this port.")
    else:
        try:
            response = await handler(request)
        except web.HTTPException as error:
            response = error
    for name, value in HEADERS.items():
        response.headers.setdefault(name, value)
    if isinstance(response, web.HTTPException):
        raise response
    return response


def has_login(request):
    return request.app[ACCESS].knows(request.cookies.get(request.app[COOKIE]))


def give_cookie(request, response):
    """Lax, not Strict: a report is in a sandbox, so a browser takes its link to the video for a link of another site. Lax sends the
    cookie with a GET that opens a page, and a GET changes nothing here."""
    response.set_cookie(request.app[COOKIE], request.app[ACCESS].login(), max_age=access.LIFETIME, httponly=True, samesite="Lax",
                        secure=request.secure, path="/")
    return response


def login_page(is_trainee, wrong="", status=200):
    """@param is_trainee: of the page that is opened after it. @param wrong: a sentence of ours, or ""."""
    text = (PAGE / "login.html").read_text(encoding="utf-8").replace("{wrong}", wrong)
    chosen = 'value="/trainee" selected' if is_trainee else 'value="/trainee"'
    return web.Response(text=text.replace('value="/trainee"', chosen), status=status, content_type="text/html")


def page(name):
    async def show(request):
        if has_login(request):
            return web.FileResponse(PAGE / name)
        if request.app[ACCESS].needs_password:
            return login_page(name == "trainee.html")
        return give_cookie(request, web.Response(body=(PAGE / name).read_bytes(), content_type="text/html", charset="utf-8"))
    return show


async def login(request):
    if not access.same_origin(request.headers.get("Origin"), request.host):
        request.app[STATION].refused["foreign_origin"] += 1
        raise web.HTTPForbidden(text="This form belongs to another page.")
    if not request.app[ACCESS].needs_password:
        raise web.HTTPFound("/")
    form = await request.post()
    wrong = await asyncio.to_thread(request.app[ACCESS].check_password, str(form.get("password", "")))
    if wrong:
        request.app[STATION].refused["wrong_password"] += 1
        return login_page(form.get("next") == "/trainee", wrong, status=403)
    response = give_cookie(request, web.Response(status=303))
    response.headers["Location"] = "/trainee" if form.get("next") == "/trainee" else "/"
    return response


async def static(request):
    name = request.match_info["name"]
    if name not in STATIC:
        raise web.HTTPNotFound(text="There is no such file.")
    return web.FileResponse(PAGE / name, headers={"Content-Type": STATIC[name]})


def demand_login(request):
    if not has_login(request):
        request.app[STATION].refused["no_cookie"] += 1
        raise web.HTTPForbidden(text="Open the station's first page and log in.")


async def session_file(request):
    demand_login(request)
    try:
        path, kind = request.app[STATION].records.file(request.match_info["session"], request.match_info["file"])
    except KeyError:
        request.app[STATION].refused["no_such_file"] += 1
        raise web.HTTPNotFound(text="There is no such file.") from None
    headers = {"Content-Type": kind}
    if path.name == "report.html":
        headers["Content-Security-Policy"] = REPORT_POLICY
    if "download" in request.query:
        headers["Content-Disposition"] = f'attachment; filename="{path.parent.name}_{path.name}"'
    return web.FileResponse(path, headers=headers)


async def class_table(request):
    demand_login(request)
    station = request.app[STATION]
    text = await asyncio.to_thread(station.records.class_csv, station.known.curriculum(request.query.get("curriculum")))
    return web.Response(text=text, content_type="text/csv", headers={"Content-Disposition": 'attachment; filename="class.csv"'})


async def websocket(request):
    station = request.app[STATION]
    if not access.same_origin(request.headers.get("Origin"), request.host):
        station.refused["foreign_origin"] += 1
        raise web.HTTPForbidden(text="This page belongs to another site.")
    demand_login(request)
    if len(station.clients) >= MOST_CLIENTS:
        station.refused["too_many_pages"] += 1
        raise web.HTTPServiceUnavailable(text=f"{MOST_CLIENTS} pages are open; close one.")
    role = "trainee" if request.query.get("page") == "trainee" else "instructor"
    socket = web.WebSocketResponse(max_msg_size=LARGEST_MESSAGE, heartbeat=5.0, compress=False)
    await socket.prepare(request)
    request.app["numbers"] += 1
    client = clients.Client(socket, role, request.app["numbers"], request.transport)
    writer = asyncio.ensure_future(client.write())
    try:
        await station.join(client)
        await listen(station, client, socket)
    finally:
        station.part(client)
        writer.cancel()
    return socket


async def listen(station, client, socket):
    async for message in socket:
        if not client.may_speak():
            station.refused["flood"] += 1
            if client.dropped > clients.MOST_DROPPED:
                await socket.close(code=1008, message=b"too many messages")
                return
            client.warn()
            continue
        if message.type == WSMsgType.ERROR:
            station.refused["too_large_or_broken"] += 1
            return
        try:
            asked = json.loads(message.data) if message.type == WSMsgType.TEXT else None
        except (ValueError, RecursionError):
            asked = None
        if not isinstance(asked, dict):
            station.refused["no_json_object"] += 1
            client.send({"t": "reply", "id": None, "ok": False, "text": "expected a JSON object"})
            continue
        if asked.get("do") == "shown":
            client.shown()
            continue
        if asked.get("do") == "hands":
            station.take_hands_message(client, asked.get("with"))
            continue
        asyncio.ensure_future(serve(station, client, asked))
    if socket.close_code == 1009:
        station.refused["too_large_or_broken"] += 1


async def serve(station, client, asked):
    number = asked.get("id")
    number = number if isinstance(number, int) and not isinstance(number, bool) and 0 <= number < 1 << 53 else None
    try:
        ok, text, more = await station.do(asked.get("do"), asked.get("with", {}), client)
    except Exception as error:  # a request of a page must not end the station
        ok, text, more = False, f"the station has an error: {type(error).__name__}", {}
        station.refused["error"] += 1
        print(f"station: {asked.get('do')!r}: {error!r}", flush=True)
    if not ok:
        station.refused["requests"] += 1
    client.send({"t": "reply", "id": number, "ok": ok, "text": text, "more": more})


def make_station(options, logs):
    own = pathlib.Path(options.config).parent if options.config else None
    station = Station(Library(options.share, own), Records(options.sessions))
    station.away = hands.Away(logs / "hands_away")
    station.link = RosLink(station.heard, station.changed)
    station.finisher = Finisher(options.programs, options.scripts, station.finished)
    reported = {"last": None}

    def changed():
        last = station.supervisor.last
        if last is not None and last != reported["last"]:
            reported["last"] = last
            station.finisher.report(last)
        station.changed()

    station.supervisor = Supervisor(options.programs, options.sessions, station.known, changed, station.records.progress,
                                    options.robot, logs, options.config, options.scale)
    return station


def make_app(options):
    """@param options: share, programs, scripts, sessions (folders), config (root file of the user's own configuration, or ""),
    robot (address or ""), scale (or None), password_hash, local (bool), port."""
    logs = pathlib.Path(options.sessions) / "station_logs"
    station = make_station(options, logs)
    app = web.Application(middlewares=[guard], client_max_size=LARGEST_BODY)
    app[STATION], app[LOCAL], app["numbers"] = station, options.local, 0
    app[ACCESS] = access.Access(options.password_hash, logs / "logins.json")
    app[COOKIE] = access.cookie_name(options.port)
    app.add_routes([web.get("/", page("instructor.html")), web.get("/trainee", page("trainee.html")), web.post("/login", login),
                    web.get("/static/{name}", static), web.get("/sessions/{session}/{file}", session_file),
                    web.get("/class.csv", class_table), web.get("/ws", websocket)])

    async def begin(_):
        station.supervisor.adopt()
        app["tasks"] = [asyncio.ensure_future(station.link.run()), asyncio.ensure_future(station.run())]

    async def end(_):
        ignore_signals()
        if station.supervisor.is_running:
            print("station: ends the session: wait for its programs", flush=True)
        if station.driving:
            station.stop_driving()
        await station.supervisor.close()
        await close_pages(station)
        if not station.is_foreign:
            station.away.set(False)
        await station.finisher.end()
        for task in app["tasks"]:
            task.cancel()
        await asyncio.gather(*app["tasks"], return_exceptions=True)

    app.on_startup.append(begin)
    app.on_shutdown.append(end)
    return app


def ignore_signals():
    """A second Ctrl-C, or the SIGTERM of roslaunch, would leave the session's programs running."""
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, lambda: None)


async def close_pages(station):
    closing = [asyncio.ensure_future(client.socket.close(code=1001, message=b"the station ends"))
               for client in station.clients.values()]
    if closing:
        await asyncio.wait(closing, timeout=CLOSE_LIMIT)


def tls(certificate, key):
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    context.load_cert_chain(certificate, key)
    return context
