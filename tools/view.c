/*
 * furrow view: a scene in a window.
 *
 * Where the ruts go: into a temporary overlay that is removed at the end, so that looking changes nothing; with --overlay into
 * that; with --write into the store itself.
 */
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "store/store.h"
#include "view.h"

static const struct command_option options[] = {
	{"store", "STORE", .help = "the terrain, instead of the scene's own", .files = "furrow"},
	{"follow", "NAME", .help = "follow this object or vehicle from the start"},
	{"overlay", "FILE", .help = "keep the deformation in FILE; made if absent", .files = "furrow"},
	{"write", .help = "deform the store itself", .instead = true},
	{"set", "KEY=VALUE", .help = "override a key of the scene, as in view.size=[800,450]", .repeats = true},
	{.name = NULL},
};

/* What the drive leaves, which nobody asked for: a folder of its own, for as long as the window is open. One a process. */
static struct shelter {
	char folder[256], overlay[288];
} shelter;

static enum status shelter_make(void)
{
	const char *parent = getenv("TMPDIR");
	if (parent == NULL || parent[0] == '\0')
		parent = "/tmp";
	int length = snprintf(shelter.folder, sizeof shelter.folder, "%s/furrow-view-XXXXXX", parent);
	if (length >= (int)sizeof shelter.folder || mkdtemp(shelter.folder) == NULL) {
		shelter.folder[0] = '\0';
		return fail_with(STATUS_FAILED, "%s: no folder can be made there: %s; name another with TMPDIR", parent,
				 length >= (int)sizeof shelter.folder ? "its name is too long" : strerror(errno));
	}
	snprintf(shelter.overlay, sizeof shelter.overlay, "%s/ruts.furrow", shelter.folder);
	return STATUS_OK;
}

static void shelter_remove(void)
{
	char path[600];
	DIR *folder = shelter.folder[0] != '\0' ? opendir(shelter.folder) : NULL;
	if (folder == NULL)
		return;
	for (struct dirent *entry; (entry = readdir(folder)) != NULL;) {
		snprintf(path, sizeof path, "%s/%s", shelter.folder, entry->d_name);
		if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0)
			unlink(path);
	}
	closedir(folder);
	if (rmdir(shelter.folder) != 0)
		note("%s: cannot be removed: %s", shelter.folder, strerror(errno));
	shelter.folder[0] = '\0';
}

/* A display that is lost ends the process where it is, with status 1: that is Xlib's doing. */
static bool watching;
static void display_lost(void)
{
	if (!watching)
		return;
	shelter_remove();
	fputs("furrow: window: the display is gone; what was committed by then is kept, run it again where there is one\n", stderr);
}

/* Before a window opens for nothing. */
static enum status check_store(const char *path)
{
	struct store *store;
	if (path == NULL)
		return fail_with(STATUS_INPUT, "view: no store is named; add store: to the scene, or give --store");
	TRY(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
	store_close(store);
	return STATUS_OK;
}

static enum status check_followed(const struct scene *scene, const char *name)
{
	char names[400] = "";
	size_t used = 0;
	for (size_t i = 0; i < scene->object_count + scene->vehicle_count && used < sizeof names; i++) {
		const char *other = i < scene->object_count ? scene->objects[i].name : scene->vehicles[i - scene->object_count].name;
		if (strcmp(other, name) == 0)
			return STATUS_OK;
		used += (size_t)snprintf(names + used, sizeof names - used, "%s%.60s", i > 0 ? ", " : "", other);
	}
	return fail_with(STATUS_USAGE, "view: --follow %.64s: the scene has no such object or vehicle; it has %s", name, names);
}

struct looking {
	struct scene *scene;
	const char *follow;
	const char *store, *overlay; /* as given; overlay NULL: temporary, unless `write` */
	bool write;
	struct window *window;
	struct viewer viewer;
};

/* Where the ruts are, or were, when it is over. */
static void say_where(const struct looking *looking, char *text, size_t size)
{
	const char *path = looking->store != NULL ? looking->store : looking->scene->store;
	if (looking->overlay != NULL)
		snprintf(text, size, "the ruts are in %s", looking->overlay);
	else if (looking->write)
		snprintf(text, size, "the ruts are in %s", path);
	else
		snprintf(text, size, "the ruts are gone, %s is as it was", path);
}

static enum status look(struct looking *looking)
{
	const struct drive_host host = viewer_host(&looking->viewer);
	const struct drive_params params = {
		.scene = looking->scene,
		.store = looking->store,
		.overlay = looking->overlay != NULL ? looking->overlay : looking->write ? NULL : shelter.overlay,
		.directory = shelter.folder,
		.host = &host,
		.stop = &interrupted,
	};
	struct drive_result result;
	char where[700];
	enum status status = drive_run(&params, &result);
	mem_free(result.json);
	if (status != STATUS_OK && status != STATUS_INTERRUPTED)
		return status;
	const struct viewer *viewer = &looking->viewer;
	say_where(looking, where, sizeof where);
	printf("view: %lld of %lld steps, %lld pictures, %lld dropped, %lld written; %s\n", (long long)result.steps, (long long)viewer->steps,
	       (long long)viewer->pictures, (long long)viewer->drops, (long long)viewer->snapshots, where);
	if (status == STATUS_INTERRUPTED)
		return fail_with(STATUS_INTERRUPTED, "view: interrupted after step %lld; %.400s", (long long)result.steps, where);
	return STATUS_OK;
}

static enum status open_window(struct looking *looking)
{
	const struct scene_view *view = &looking->scene->view;
	TRY(window_open("furrow: loads", view->width, view->height, &looking->window));
	viewer_init(&looking->viewer, looking->window, looking->scene);
	looking->viewer.follow = looking->follow;
	looking->viewer.store = looking->store != NULL ? looking->store : looking->scene->store;
	if (chart_missing() == NULL)
		return chart_pen_create(&looking->viewer.pen);
	note("view: no text is on the picture: %s", chart_missing());
	return STATUS_OK;
}

static enum status run(const struct arguments *arguments)
{
	struct settings settings = {.count = 0};
	struct looking looking = {
		.follow = arguments_text(arguments, "follow"),
		.store = arguments_text(arguments, "store"),
		.overlay = arguments_text(arguments, "overlay"),
		.write = arguments_flag(arguments, "write"),
	};
	bool temporary = looking.overlay == NULL && !looking.write;
	if (looking.write && looking.overlay != NULL)
		return fail_with(STATUS_USAGE, "view: --write and --overlay name two places for the ruts; give one of them");
	enum status status;
	TRY_OR(done, settings_take(arguments, &settings));
	TRY_OR(done, view_scene_load(arguments_at(arguments, 0), &settings, &looking.scene));
	if (looking.follow != NULL)
		TRY_OR(done, check_followed(looking.scene, looking.follow));
	if (temporary)
		TRY_OR(done, check_store(looking.store != NULL ? looking.store : looking.scene->store));
	TRY_OR(done, open_window(&looking));
	TRY_OR(done, shelter_make());
	TRY_OR(done, atexit(display_lost) == 0 ? STATUS_OK : fail_memory("what is done when the display is lost"));
	interrupt_catch();
	if (temporary)
		note("looking changes nothing: the ruts are gone at the end (--overlay FILE keeps them, --write deforms the store)");
	watching = true;
	status = look(&looking);
	watching = false;
done:;
	struct failure failure;
	failure_capture(&failure, status);
	chart_pen_destroy(looking.viewer.pen);
	viewer_finish(&looking.viewer);
	window_close(looking.window);
	shelter_remove();
	scene_destroy(looking.scene);
	settings_finish(&settings);
	return status == STATUS_OK ? STATUS_OK : failure_restore(&failure);
}

const struct command command_view = {
	.name = "view",
	.summary = "a scene in a window: fly, follow, pause, step, drop objects",
	.arguments = COMMAND_ARGUMENTS(COMMAND_SCENE),
	.options = options,
	.details = view_keys_text,
	.examples = "furrow view scene.yaml --store world.furrow\n",
	.see = "furrow-drive(1), scene(5)",
	.run = run,
};
