/* The rows of the view, of cameras and of lidars. What a row says, and how a key is added: scene_row.h and scene_schema.h. */
#include "scene/scene.h"
#include "scene/scene_schema.h"

static const struct scene_word body_words[] = {{"earth", SCENE_EARTH}, {"mars", SCENE_MARS}, {"moon", SCENE_MOON}, {NULL, 0}};
static const struct scene_word camera_words[] = {{"mounted", SCENE_MOUNTED}, {"fixed", SCENE_FIXED}, {"chase", SCENE_CHASE}, {"overhead", SCENE_OVERHEAD}, {"poses", SCENE_BY_POSES}, {NULL, 0}};
static const struct scene_word exposure_words[] = {{"fixed", SCENE_EXPOSURE_FIXED}, {"sun", SCENE_EXPOSURE_SUN}, {"auto", SCENE_EXPOSURE_AUTO}, {NULL, 0}};

static const struct scene_row overhead_rows[] = {
	{NEEDED_TEXT("over", struct raw_overhead, over, 64), .since = "0.1.0",
	 .text = "an object's name"},
	{NEEDED_NUMBER("height", struct raw_overhead, height), ABOVE(0, 1e6), .unit = "m", .since = "0.1.0",
	 .text = "above the ground under it"},
	{.key = NULL},
};
static const struct scene_row fixed_rows[] = {
	{NEEDED_NUMBERS("eye", struct raw_fixed, eye, 3), RANGE(-1e9, 1e9), .unit = "m", .since = "0.1.0",
	 .text = "where it is: local x, y, and height as the store's"},
	{NEEDED_NUMBERS("target", struct raw_fixed, target, 3), RANGE(-1e9, 1e9), .unit = "m", .since = "0.1.0",
	 .text = "what it looks at; not the eye"},
	{.key = NULL},
};
static const struct scene_row camera_rows[] = {
	{TEXT("chase", struct raw_camera, chase, 64), .needs = "needed, or another camera", .since = "0.1.0",
	 .text = "an object's name: behind it, looking at the ground under it"},
	{NUMBER("back", struct raw_camera, back), RANGE(0, 1e6), .unit = "m", DEFAULT(12), .since = "0.1.0",
	 .text = "how far behind it; chase alone"},
	{NUMBER("up", struct raw_camera, up), RANGE(0, 1e6), .unit = "m", DEFAULT(5), .since = "0.1.0",
	 .text = "how far above the ground; chase alone; not 0 with back 0"},
	{MAPPING("overhead", struct raw_camera, overhead, struct raw_overhead, overhead_rows), .needs = "needed, or another camera", .since = "0.1.0",
	 .text = "looks down, north up; its keys may stand in `camera` itself"},
	{MAPPING("fixed", struct raw_camera, fixed, struct raw_fixed, fixed_rows), .needs = "needed, or another camera", .since = "0.1.0",
	 .text = "stands still; its keys may stand in `camera` itself"},
	{.key = NULL},
};
static const struct scene_row sun_rows[] = {
	{NUMBER("azimuth", struct raw_sun, azimuth), RANGE(0, 360), .unit = "degrees", DEFAULT(135), .since = "0.1.0",
	 .text = "clockwise from north"},
	{NUMBER("height", struct raw_sun, height), RANGE(0, 90), .unit = "degrees", DEFAULT(35), .since = "0.1.0",
	 .text = "above the horizon; low over the Earth it is red"},
	{TEXT("time", struct raw_sun, time, 64), .otherwise = "azimuth and height", .since = "0.2.0",
	 .text = "UTC at the drive's beginning, as `2026-11-27T16:00:00Z`: the sun is where it is then, and moves"},
	{NUMBERS("at", struct raw_sun, at, 2, 2), RANGE(-360, 360), .unit = "degrees", .otherwise = "the middle of the store's terrain", .since = "0.2.0",
	 .text = "of `time`: longitude (east) and latitude of the place, on `view.body`"},
	{NUMBERS("colour", struct raw_sun, colour, 3, 3), RANGE(0, 10), .otherwise = "the body's sun at its height", .since = "0.1.0",
	 .text = "its light, linear: red, green, blue; the Earth's at 35 degrees is 1, 0.9, 0.75"},
	{.key = NULL},
};
const struct scene_row scene_view_rows[] = {
	{WHOLES("size", struct raw_view, size, 2, 2), RANGE(1, 8192), .unit = "pixels", .otherwise = "1280, 720", .since = "0.1.0",
	 .text = "width, height"},
	{MAPPING("camera", struct raw_view, camera, struct raw_camera, camera_rows), .command = true, .since = "0.1.0",
	 .text = "exactly one of chase, overhead, fixed"},
	{TEXTS("effects", struct raw_view, effects, 64, 0, ENDLESS), .otherwise = "none", .since = "0.1.0",
	 .text = "of `texture`, `detail`, `fog`, `sky`, `geomorph`, `skirts`, `splat` (soils of the map as they look; with texture), `objects`, `shadow` (of objects), `terrain_shadow` (of the ground itself), `imagery` ([of the store](../../docs/CAMERAS.md#imagery))"},
	{WHOLE("images", struct raw_view, images), RANGE(0, 1e9), .unit = "steps", DEFAULT(0), .since = "0.1.0",
	 .text = "writes frame-NNNNNN.png every so many; 0: none"},
	{WHOLE("samples", struct raw_view, samples), RANGE(1, 8), DEFAULT(1), .since = "0.1.0",
	 .text = "samples a pixel, 1, 2, 4 or 8: [smooth edges](#pictures)"},
	{NUMBER("pixel_error", struct raw_view, pixel_error), ABOVE(0, 64), .unit = "pixels", .otherwise = "by distance alone", .since = "0.1.0",
	 .text = "the ground may be drawn off by so much; smaller is finer"},
	{NUMBER("imagery_budget", struct raw_view, imagery_budget), ABOVE(0, 65536), .unit = "MB", DEFAULT(128), .since = "0.2.0",
	 .text = "GPU memory for tiles of imagery, beside those of heights; no picture depends on it"},
	{SWITCH("truth", struct raw_view, truth), .otherwise = "true for all cameras but chase", .since = "0.2.0",
	 .text = "the light is that of the drawn surface alone, so that [colour agrees with depth](../../docs/CAMERAS.md#colour-that-agrees-with-depth)"},
	{WORD("exposure", struct raw_view, exposure, exposure_words), .otherwise = "fixed", .since = "0.2.0",
	 .text = "sun: level ground is as bright as under the default sun, however low it is: up to 32 times more; auto: [the frame's mean light](../../docs/CAMERAS.md#exposure) is a middle grey"},
	{NUMBER("ev", struct raw_view, ev), RANGE(-16, 16), .unit = "stops", DEFAULT(0), .since = "0.2.0",
	 .text = "pictures are 2^ev times as bright as `exposure` alone makes them"},
	{WORD("body", struct raw_view, body, body_words), .otherwise = "the store's, or earth", .since = "0.1.0",
	 .text = "where the ground is: its colours, its sky, its sun; on the Moon there is no air, and no fog"},
	{MAPPING("sun", struct raw_view, sun, struct raw_sun, sun_rows), .otherwise = "as below", .since = "0.1.0",
	 .text = "the sun that the picture is lit by"},
	{.key = NULL},
};
/* How the pose of a camera or of a lidar is turned. */
#define POSE_TURNS \
	{NUMBER("yaw", struct raw_camera_pose, yaw), RANGE(-36000, 36000), .unit = "degrees", DEFAULT(0), .since = "0.2.0", \
	 .text = "as of [path files](#path-files)"}, \
	{NUMBER("pitch", struct raw_camera_pose, pitch), RANGE(-36000, 36000), .unit = "degrees", DEFAULT(0), .since = "0.2.0", \
	 .text = "then up"}, \
	{NUMBER("roll", struct raw_camera_pose, roll), RANGE(-36000, 36000), .unit = "degrees", DEFAULT(0), .since = "0.2.0", \
	 .text = "then right side down"},
static const struct scene_row camera_pose_rows[] = {
	{NEEDED_NUMBERS("at", struct raw_camera_pose, at, 3), RANGE(-1e9, 1e9), .unit = "m", .since = "0.2.0",
	 .text = "fixed: x, y, and height as the store has it; mounted: forward, left, up"},
	{NUMBERS("target", struct raw_camera_pose, target, 3, 3), RANGE(-1e9, 1e9), .unit = "m", .otherwise = "yaw, pitch and roll", .since = "0.2.0",
	 .text = "what it looks at, in the same axes"},
	POSE_TURNS
	{.key = NULL},
};
const struct scene_row scene_camera_rows[] = {
	{NEEDED_TEXT("name", struct raw_listed_camera, name, 48), .since = "0.2.0",
	 .text = "unique, also of its folder; A-Z a-z 0-9 _ -"},
	{NEEDED_WORD("kind", struct raw_listed_camera, kind, camera_words), .since = "0.2.0",
	 .text = "what it follows"},
	{TEXT("on", struct raw_listed_camera, on, 64), .needs = "needed with mounted, chase, overhead", .since = "0.2.0",
	 .text = "an object or a vehicle"},
	{TEXT("body", struct raw_listed_camera, body, 64), .otherwise = "the root body", .since = "0.2.0",
	 .text = "mounted on a vehicle: a body of its model, as a mast"},
	{MAPPING("pose", struct raw_listed_camera, pose, struct raw_camera_pose, camera_pose_rows), .needs = "needed with fixed", .since = "0.2.0",
	 .text = "mounted: against the body's axes (default: in its centre); fixed: local"},
	{NUMBER("back", struct raw_listed_camera, back), RANGE(0, 1e6), .unit = "m", DEFAULT(12), .since = "0.2.0",
	 .text = "chase: how far behind it"},
	{NUMBER("up", struct raw_listed_camera, up), RANGE(0, 1e6), .unit = "m", DEFAULT(5), .since = "0.2.0",
	 .text = "chase: how far above the ground; not 0 with back 0"},
	{NUMBER("height", struct raw_listed_camera, height), ABOVE(0, 1e6), .unit = "m", .otherwise = "needed with overhead", .since = "0.2.0",
	 .text = "above the ground under it"},
	{TEXT("file", struct raw_listed_camera, file, 4096), .needs = "needed with poses", .since = "0.2.0",
	 .text = "`t,x,y,z,yaw,pitch,roll`, as of [path files](#path-files), always local"},
	{NUMBER("fov", struct raw_listed_camera, fov), RANGE(1, 170), .unit = "degrees", DEFAULT(60), .since = "0.2.0",
	 .text = "angle of view from its left side to its right one"},
	{WHOLES("size", struct raw_listed_camera, size, 2, 2), RANGE(1, 8192), .unit = "pixels", .otherwise = "640, 480", .since = "0.2.0",
	 .text = "width, height"},
	{NEEDED_NUMBER("rate", struct raw_listed_camera, rate), ABOVE(0, 1e6), .unit = "1/s", .since = "0.2.0",
	 .text = "frames for each second of simulated time; at most one a step"},
	{TEXTS("images", struct raw_listed_camera, images, 64, 1, ENDLESS), .otherwise = "colour", .since = "0.2.0",
	 .text = "of `colour`, `depth`, `normals`, `height`, `class` (soil, object, vehicle), `instance` (body), `linear` ([light](../../docs/CAMERAS.md#exposure), 16 bits)"},
	{WORD("exposure", struct raw_listed_camera, exposure, exposure_words), .otherwise = "the view's", .since = "0.2.0",
	 .text = "as of `view`, for this camera"},
	{NUMBER("ev", struct raw_listed_camera, ev), RANGE(-16, 16), .unit = "stops", .otherwise = "the view's", .since = "0.2.0",
	 .text = "as of `view`, for this camera"},
	{NUMBER("depth_unit", struct raw_listed_camera, depth_unit), RANGE(1e-6, 1000), .unit = "m", DEFAULT(0.001), .since = "0.2.0",
	 .text = "metres of 1 in 16-bit pictures of depth"},
	{NUMBER("stereo", struct raw_listed_camera, stereo), ABOVE(0, 1000), .unit = "m", .otherwise = "none", .since = "0.2.0",
	 .text = "a second camera, NAME_right, so far to its right"},
	{SWITCH("video", struct raw_listed_camera, video), .otherwise = "false", .since = "0.2.0",
	 .text = "`colour.mp4` of its pictures at the end, if there is ffmpeg"},
	{.key = NULL},
};
static const struct scene_row lidar_pose_rows[] = {
	{NEEDED_NUMBERS("at", struct raw_camera_pose, at, 3), RANGE(-1e9, 1e9), .unit = "m", .since = "0.2.0",
	 .text = "forward, left, up; else x, y, and height as the store has it"},
	{NUMBERS("target", struct raw_camera_pose, target, 3, 3), RANGE(-1e9, 1e9), .unit = "m", .otherwise = "yaw, pitch and roll", .since = "0.2.0",
	 .text = "where its forward looks, in the same axes"},
	POSE_TURNS
	{.key = NULL},
};
const struct scene_row scene_lidar_rows[] = {
	{NEEDED_TEXT("name", struct raw_lidar, name, 48), .since = "0.2.0",
	 .text = "unique among lidars and cameras; A-Z a-z 0-9 _ -"},
	{TEXT("on", struct raw_lidar, on, 64), .needs = "needed, or pose", .since = "0.2.0",
	 .text = "a vehicle"},
	{TEXT("body", struct raw_lidar, body, 64), .otherwise = "the root body", .since = "0.2.0",
	 .text = "a body of its model"},
	{MAPPING("pose", struct raw_lidar, pose, struct raw_camera_pose, lidar_pose_rows), .needs = "needed, or on", .since = "0.2.0",
	 .text = "on a vehicle: against the body's axes (default: in its origin); else local"},
	{WHOLES("rays", struct raw_lidar, rays, 2, 2), RANGE(1, 4096), .otherwise = "360, 16", .since = "0.2.0",
	 .text = "around, up; at most 4194304 in all"},
	{NUMBERS("fov", struct raw_lidar, fov, 2, 2), RANGE(0, 360), .unit = "degrees", .otherwise = "360, 30", .since = "0.2.0",
	 .text = "around; up, from the lowest to the highest, at most 180"},
	{NUMBERS("range", struct raw_lidar, range, 2, 2), RANGE(0, 1e5), .unit = "m", .otherwise = "0, 100", .since = "0.2.0",
	 .text = "what is nearer or farther is not measured"},
	{NEEDED_NUMBER("rate", struct raw_lidar, rate), ABOVE(0, 1e6), .unit = "1/s", .since = "0.2.0",
	 .text = "frames for each second of simulated time; at most one a step"},
	{NUMBER("noise", struct raw_lidar, noise), RANGE(0, 100), .unit = "m", DEFAULT(0), .since = "0.2.0",
	 .text = "standard deviation of a range"},
	{NUMBER("dropout", struct raw_lidar, dropout), RANGE(0, 1), DEFAULT(0), .since = "0.2.0",
	 .text = "share of rays that give nothing"},
	{.key = NULL},
};
