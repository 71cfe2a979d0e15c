/*
 * The host of the drive that furrow view shows: what was pressed in the window becomes what the drive does next, and what it
 * drew comes into the window.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "view.h"

#define TITLE_EVERY 0.5  /* s */
#define TELL_FOR 4.0     /* s: what was done stays in the line of figures */
#define TURN_MOST 0.2    /* s: nobody flies on while a turn takes longer */
#define SNAPSHOTS_MOST 9999

void viewer_init(struct viewer *viewer, struct window *window, const struct scene *scene)
{
	const struct scene_view *view = &scene->view;
	*viewer = (struct viewer){
		.window = window,
		.eye = {.back = view->aim.kind == SCENE_CHASE && view->aim.back > 0 ? view->aim.back : 12,
			.up = view->aim.kind == SCENE_CHASE && view->aim.up > 0 ? view->aim.up : 5},
		.fly_before = clock_seconds(),
		.line = true,
		.told = "",
		.rate = (double)NAN,
	};
}

void viewer_tell(struct viewer *viewer, const char *format, ...)
{
	va_list arguments;
	va_start(arguments, format);
	vsnprintf(viewer->message, sizeof viewer->message, format, arguments);
	va_end(arguments);
	viewer->told = viewer->message;
	viewer->told_until = clock_seconds() + TELL_FOR;
	viewer->again = true;
}

/* --- the eye --- */

static enum status ground_below(struct drive *drive, const double eye[3], double *ground)
{
	const struct store_meta *meta = drive_store(drive);
	const struct resident_point point = {eye[0], eye[1]};
	struct resident_height found = {.height = NAN};
	enum status status = drive_heights(drive, &point, 1, &found);
	*ground = !isnan(found.height) ? found.height : isnan(meta->low) ? 0 : meta->low;
	return status;
}

static bool flies(const struct window *window, double way[3])
{
	bool held[VIEW_ACTIONS_HELD];
	for (int i = 0; i < VIEW_ACTIONS_HELD; i++)
		held[i] = view_action_held(window, (enum view_action)i);
	way[0] = held[VIEW_FORWARD] - held[VIEW_BACK];
	way[1] = held[VIEW_RIGHT] - held[VIEW_LEFT];
	way[2] = held[VIEW_UP] - held[VIEW_DOWN];
	return way[0] != 0 || way[1] != 0 || way[2] != 0;
}

static enum status place_eye(struct viewer *viewer, struct drive *drive, double seconds)
{
	struct view_eye *eye = &viewer->eye;
	struct render_camera camera;
	double way[3], place[3], yaw, ground = 0;
	if (flies(viewer->window, way))
		eye->mode = VIEW_MODE_FLY;
	else
		memset(way, 0, sizeof way);
	if (eye->mode == VIEW_MODE_SCENE) {
		drive_scene_camera(drive, &camera);
		view_eye_take(eye, &camera);
		return STATUS_OK;
	}
	bool follows = eye->mode == VIEW_MODE_FOLLOW;
	if (follows) {
		drive_place(drive, eye->object, place, &yaw);
		view_eye_follow(eye, place, yaw, seconds);
	}
	enum status status = ground_below(drive, eye->eye, &ground);
	if (follows)
		view_eye_rise(eye, place, ground);
	if (eye->mode == VIEW_MODE_FLY && status == STATUS_OK && (way[0] != 0 || way[1] != 0 || way[2] != 0)) {
		view_eye_fly(eye, way, seconds, eye->eye[2] - ground, window_held(viewer->window, WINDOW_SHIFT));
		status = ground_below(drive, eye->eye, &ground);
	}
	view_eye_clear(eye, ground);
	return status;
}

/* --- dropping --- */

static enum status drop_at(struct viewer *viewer, struct drive *drive, double x, double y)
{
	struct resident_hit hit;
	bool pressed = false;
	TRY(view_ground_at(viewer, drive, x, y, &hit));
	if (hit.hit)
		TRY(drive_drop(drive, viewer->shape, hit.point[0], hit.point[1], viewer->eye.yaw, &pressed));
	viewer->drops += pressed;
	if (pressed)
		viewer_tell(viewer, "dropped at %.2f, %.2f", hit.point[0], hit.point[1]);
	else
		viewer_tell(viewer, drive_scene(drive)->object_count == 0 ? "the scene has no object: its ground does not give" :
								   "there is no ground");
	return STATUS_OK;
}

/* Where the cursor is; elsewhere than over the window: its middle. */
static void cursor(const struct viewer *viewer, double *x, double *y)
{
	int at[2], width, height;
	window_size(viewer->window, &width, &height);
	bool over = window_mouse(viewer->window, &at[0], &at[1]);
	*x = over ? at[0] : width / 2;
	*y = over ? at[1] : height / 2;
}

/* --- what was pressed --- */

static void change_pace(struct viewer *viewer, int by)
{
	viewer->pace += by;
	viewer->pace = viewer->pace < VIEW_PACE_LEAST ? VIEW_PACE_LEAST : viewer->pace > VIEW_PACE_MOST ? VIEW_PACE_MOST : viewer->pace;
	if (viewer->pace == VIEW_PACE_MOST)
		viewer_tell(viewer, "as fast as it can");
	else
		viewer_tell(viewer, "%g times real time", ldexp(1, viewer->pace));
}

static void show_layer(struct viewer *viewer, const struct scene *scene, int which)
{
	static const char *const names[RENDER_LAYERS] = {"natural colours", "offset", "dirt", "height", "slope", "tiles, by level"};
	viewer->layer = (enum render_layer_kind)which;
	viewer_tell(viewer, viewer->layer == RENDER_DISTURBANCE && !scene->disturbance ? "the scene keeps no dirt" : "%s", names[which]);
}

static enum status key_down(struct viewer *viewer, struct drive *drive, int key)
{
	int which = 0;
	double x, y;
	cursor(viewer, &x, &y);
	switch (view_action_of(key, &which)) {
	case VIEW_FOLLOW:
		view_follow(viewer, drive, viewer->eye.mode == VIEW_MODE_FOLLOW ? viewer->eye.object + 1 : 0);
		break;
	case VIEW_MARK:
		return view_mark(viewer, drive);
	case VIEW_BACK_TO:
		return view_go_back(viewer, drive);
	case VIEW_SEND:
		return view_send(viewer, drive, x, y);
	case VIEW_GRAPH:
		viewer->graph = !viewer->graph;
		viewer->again = true;
		break;
	case VIEW_MAP:
		view_show_map(viewer);
		break;
	case VIEW_RESET:
		viewer->eye.mode = VIEW_MODE_SCENE;
		viewer_tell(viewer, "the scene's camera");
		break;
	case VIEW_PAUSE:
		viewer->paused = !viewer->paused;
		viewer->ones = 0;
		viewer_tell(viewer, viewer->paused ? "paused" : "goes on");
		break;
	case VIEW_ONE_STEP:
		viewer->paused = true;
		viewer->ones++;
		break;
	case VIEW_SLOWER:
		change_pace(viewer, -1);
		break;
	case VIEW_FASTER:
		change_pace(viewer, 1);
		break;
	case VIEW_DROP:
		return drop_at(viewer, drive, x, y);
	case VIEW_SHAPE:
		viewer->shape = (viewer->shape + 1) % WORLD_DROP_SHAPES;
		viewer_tell(viewer, viewer->shape == WORLD_DROP_BALL ? "drops a ball" : "drops the first object's shape");
		break;
	case VIEW_LAYER:
		show_layer(viewer, drive_scene(drive), which);
		break;
	case VIEW_SNAPSHOT:
		viewer->snapshot = viewer->again = true;
		break;
	case VIEW_LINE:
		viewer->line = !viewer->line;
		viewer->again = true;
		break;
	case VIEW_HELP:
		viewer->help = !viewer->help;
		viewer->again = true;
		break;
	case VIEW_END:
		viewer->ended = true;
		break;
	default: /* flying: while it is held */
		break;
	}
	return STATUS_OK;
}

static enum status take_events(struct viewer *viewer, struct drive *drive)
{
	struct window_event event;
	int width, height;
	while (window_next(viewer->window, &event)) {
		window_size(viewer->window, &width, &height);
		if (event.kind == WINDOW_CLOSE)
			viewer->ended = true;
		else if (event.kind == WINDOW_EXPOSED)
			viewer->again = true;
		else if (event.kind == WINDOW_KEY)
			TRY(key_down(viewer, drive, event.key));
		else if (event.kind == WINDOW_CLICK)
			TRY(drop_at(viewer, drive, event.x, event.y));
		else if (event.kind == WINDOW_PICK)
			TRY(view_pick(viewer, drive, event.x, event.y));
		else if (event.dx != 0 || event.dy != 0) {
			if (viewer->eye.mode == VIEW_MODE_SCENE)
				viewer->eye.mode = VIEW_MODE_FLY;
			view_eye_drag(&viewer->eye, event.dx, event.dy, height);
		}
	}
	return STATUS_OK;
}

/* --- the host's calls --- */

static bool watched(const struct viewer *viewer, const struct drive *drive, struct drive_followed *out)
{
	size_t number;
	if (!view_watched(viewer, drive, &number))
		return false;
	drive_followed(drive, number, out);
	return true;
}

static void write_title(struct viewer *viewer, struct drive *drive, double now)
{
	struct drive_followed followed;
	struct drive_figures figures;
	char figured[400], title[440];
	if (now - viewer->titled < TITLE_EVERY)
		return;
	drive_figures(drive, &figures);
	viewer->steps = figures.steps;
	viewer->rate = viewer->titled > 0 ? (figures.time - viewer->titled_time) / (now - viewer->titled) : (double)NAN;
	viewer->titled = now;
	viewer->titled_time = figures.time;
	view_figures_text(viewer, &figures, watched(viewer, drive, &followed) ? &followed : NULL, figured, sizeof figured);
	snprintf(title, sizeof title, "furrow: %s", figured);
	window_title(viewer->window, title);
}

static uint32_t side_of(int pixels)
{
	return pixels < 1 ? 1 : (uint32_t)pixels > DRIVE_PICTURE_MOST ? DRIVE_PICTURE_MOST : (uint32_t)pixels;
}

static void fill_wish(struct viewer *viewer, struct drive_control *wish)
{
	int width, height;
	window_size(viewer->window, &width, &height);
	wish->go = viewer->ended ? DRIVE_STOP : viewer->ones > 0 ? DRIVE_ONE : viewer->paused ? DRIVE_HOLD : DRIVE_ON;
	wish->pace = viewer->pace == VIEW_PACE_MOST ? INFINITY : ldexp(1, viewer->pace);
	wish->free = viewer->eye.mode != VIEW_MODE_SCENE;
	view_eye_camera(&viewer->eye, &wish->camera);
	wish->layer = viewer->layer;
	wish->width = side_of(width);
	wish->height = side_of(height);
	wish->again = wish->again || viewer->again;
	viewer->ones -= viewer->ones > 0;
	viewer->again = false;
}

static enum status turn(void *user, struct drive *drive, struct drive_control *wish)
{
	struct viewer *viewer = user;
	size_t number;
	double now = clock_seconds(), seconds = fmin(now - viewer->fly_before, TURN_MOST);
	viewer->fly_before = now;
	view_follow_named(viewer, drive);
	TRY(take_events(viewer, drive));
	TRY(view_track_take(&viewer->track, drive, view_watched(viewer, drive, &number) ? number : SIZE_MAX));
	TRY(place_eye(viewer, drive, seconds));
	if (viewer->told[0] != '\0' && now > viewer->told_until) {
		viewer->told = "";
		viewer->again = true;
	}
	write_title(viewer, drive, now);
	fill_wish(viewer, wish);
	return STATUS_OK;
}

/* Under the first number that is free. What cannot be written is told, and nothing ends for it. */
static void write_snapshot(struct viewer *viewer, const uint8_t *pixels, uint32_t width, uint32_t height)
{
	char path[32];
	int number = 0;
	do
		snprintf(path, sizeof path, "view-%04d.png", ++number);
	while (number < SNAPSHOTS_MOST && access(path, F_OK) == 0);
	viewer->snapshot = false;
	if (chart_png_write(path, pixels, width, height) != STATUS_OK) {
		viewer_tell(viewer, "%.90s", failure_message());
		return;
	}
	viewer->snapshots++;
	viewer_tell(viewer, "wrote %s", path);
}

static enum status picture(void *user, struct drive *drive, uint8_t *pixels, uint32_t width, uint32_t height)
{
	struct viewer *viewer = user;
	struct drive_figures figures;
	struct drive_followed followed;
	int top;
	drive_figures(drive, &figures);
	viewer->pictures++;
	TRY(view_draw_targets(viewer, drive, pixels, width, height));
	TRY(view_draw_over(viewer, &figures, watched(viewer, drive, &followed) ? &followed : NULL, pixels, width, height, &top));
	TRY(view_draw_graph(viewer, drive, pixels, width, height));
	TRY(view_draw_map(viewer, drive, pixels, width, height, top));
	if (viewer->snapshot)
		write_snapshot(viewer, pixels, width, height);
	return window_show(viewer->window, pixels, (int)width, (int)height);
}

void viewer_finish(struct viewer *viewer)
{
	view_track_finish(&viewer->track);
	view_map_finish(&viewer->map);
}

struct drive_host viewer_host(struct viewer *viewer)
{
	return (struct drive_host){viewer, turn, picture};
}
