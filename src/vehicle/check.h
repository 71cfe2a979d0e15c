/* Looks at a model before MuJoCo reads it: what it asks for, and which files it names. */
#ifndef FURROW_VEHICLE_CHECK_H
#define FURROW_VEHICLE_CHECK_H

#include "base/base.h"

/* A file that the model names. */
struct vehicle_check_name {
	char *text;
	bool include; /* it is XML, and part of the model */
};

struct vehicle_check {
	const char *where, *path; /* the vehicle, for messages; the model's file */
	struct vehicle_check_name *names;
	size_t name_count, name_room;
	char *folders[8]; /* meshdir and texturedir, as they are written */
	size_t folder_count;
	size_t elements, bodies, keys, joints; /* joints: those that say no type, or one of a single axis */
	double freedoms;                       /* of the other joints, and of composites */
	double heaviest;                       /* degrees of freedom of a joint that says no type */
	double bytes;                          /* that hfields, textures and other lists take */
	char *reach;                           /* an absolute path; names must not lead out of this folder */
	size_t texts;                          /* bytes of XML */
	bool urdf, welded;                     /* its outermost element is `robot`; it has a link `world` */
};

/* Refuses a model that takes more memory than a vehicle needs, or that names files out of its reach. STATUS_INPUT: the message
 * begins with `where`, and names the limit. MuJoCo can then read the model: it may still refuse it. *urdf: it is one. *welded: that has a link
 * named world. */
enum status vehicle_check_model(const char *where, const char *path, bool *urdf, bool *welded) FURROW_CHECKED;

/* --- check_files.c --- */
enum status vehicle_check_name_add(struct vehicle_check *check, const char *text, size_t length, bool include) FURROW_CHECKED;
enum status vehicle_check_folder_add(struct vehicle_check *check, const char *text, size_t length) FURROW_CHECKED;
/* Finds the folder that names must not lead out of: the one above the model's. */
enum status vehicle_check_reach(struct vehicle_check *check) FURROW_CHECKED;
/* Looks at a file that was named, wherever MuJoCo may look for it. Images are counted in check->bytes. */
enum status vehicle_check_name(struct vehicle_check *check, const char *name) FURROW_CHECKED;
/* Reads a part of the model: at most VEHICLE_CHECK_TEXTS with those before. *text is to be freed with mem_free. */
enum status vehicle_check_read(struct vehicle_check *check, const char *path, char **text, size_t *length) FURROW_CHECKED;
/* Looks at the file of a mesh of a URDF. `name`: as the model names it. */
enum status vehicle_check_mesh_file(const char *where, const char *model, const char *path, const char *name) FURROW_CHECKED;
#define VEHICLE_CHECK_TEXTS ((size_t)64 << 20)
#define VEHICLE_CHECK_FILE ((int64_t)64 << 20) /* bytes of one mesh, image or height field */
/* Returns true if `path`, an absolute one, lies in a folder. */
bool vehicle_check_is_below(const char *path, const char *folder);
/* Cuts the last part of an absolute path off; of "/" nothing. */
void vehicle_check_cut(char *path);
/* --- check_mesh.c --- */
/* Return why MuJoCo must not read this OBJ or MSH; NULL: it may. `text` has a NUL behind it, and is changed. */
const char *vehicle_check_obj(char *text, size_t length);
const char *vehicle_check_msh(const char *bytes, size_t length);
/* Returns true if all numbers of a text are numbers of vertices. */
bool vehicle_check_faces(const char *faces, size_t length, size_t vertices);
/* --- check_files.c --- */
/* Returns the path of a name in the model's folder, or in a folder within it; `folder` may be NULL. To be freed with mem_free. */
char *vehicle_check_path(const struct vehicle_check *check, const char *folder, const char *name);

#endif
