/*
 * Reads mesh files. A glTF is read by scene_gltf.c: assimp follows its brackets and nodes without a limit. OBJ, STL and DAE are read by
 * assimp, once scene_mesh_count.c has counted what they have. assimp gets bytes and never a path, and opens no other file.
 */
#include "scene/scene_mesh_import.h"

#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "scene/scene_file.h"
#include "scene/scene_gltf.h"

#define DEPTH_MAX 256 /* of nodes */

/* The one file that an import may open. It was read before. */
struct given {
	char name[16]; /* that assimp is told, in place of its path */
	const char *bytes;
	size_t length;
	char beside_name[80]; /* a second file: the materials of an OBJ. Empty: none */
	char *beside;
	size_t beside_length;
};

struct open_file {
	struct aiFile file;
	const char *bytes; /* the content */
	size_t length, at; /* bytes of it; place of the next read */
};

/* --- files that assimp reads --- */

static struct open_file *opened(struct aiFile *file)
{
	return (struct open_file *)(void *)file->UserData;
}

static size_t read_proc(struct aiFile *file, char *to, size_t size, size_t count)
{
	struct open_file *open = opened(file);
	size_t can = size > 0 ? (open->length - open->at) / size : 0;
	if (count > can)
		count = can;
	memcpy(to, open->bytes + open->at, size * count);
	open->at += size * count;
	return count;
}

static size_t write_proc(struct aiFile *file, const char *from, size_t size, size_t count)
{
	return 0;
}

static size_t tell_proc(struct aiFile *file)
{
	return opened(file)->at;
}

static size_t size_proc(struct aiFile *file)
{
	return opened(file)->length;
}

static enum aiReturn seek_proc(struct aiFile *file, size_t offset, enum aiOrigin origin)
{
	struct open_file *open = opened(file);
	size_t from = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? open->at : open->length;
	if (offset > open->length - from)
		return aiReturn_FAILURE;
	open->at = from + offset;
	return aiReturn_SUCCESS;
}

static void flush_proc(struct aiFile *file)
{
}

static struct aiFile *open_proc(struct aiFileIO *io, const char *name, const char *mode)
{
	const struct given *given = (const struct given *)(void *)io->UserData;
	if (strncmp(name, "./", 2) == 0)
		name += 2;
	const bool beside = given->beside != NULL && strcmp(name, given->beside_name) == 0;
	struct open_file *open = beside || strcmp(name, given->name) == 0 ? mem_calloc(1, sizeof *open) : NULL;
	if (open == NULL)
		return NULL;
	open->bytes = beside ? given->beside : given->bytes;
	open->length = beside ? given->beside_length : given->length;
	open->file = (struct aiFile){
		.ReadProc = read_proc,
		.WriteProc = write_proc,
		.TellProc = tell_proc,
		.FileSizeProc = size_proc,
		.SeekProc = seek_proc,
		.FlushProc = flush_proc,
		.UserData = (aiUserData)(void *)open,
	};
	return &open->file;
}

static void close_proc(struct aiFileIO *io, struct aiFile *file)
{
	struct open_file *open = opened(file);
	mem_free(open);
}

/* --- triangles from assimp's scene --- */

static enum status too_many(const char *told)
{
	return fail_with(STATUS_INPUT, "%s: it has more than %u triangles; give a coarser mesh", told, SCENE_MESH_TRIANGLES);
}

static enum status count_node(const struct aiScene *scene, const struct aiNode *node, int depth, const char *told,
			      size_t *triangles, size_t *nodes)
{
	if (depth == DEPTH_MAX || ++*nodes > SCENE_MESH_TRIANGLES)
		return fail_with(STATUS_INPUT, "%s: its nodes are too many or too deep; allowed: %u, %d deep", told,
				 SCENE_MESH_TRIANGLES, DEPTH_MAX);
	for (unsigned i = 0; i < node->mNumMeshes; i++) {
		if (node->mMeshes[i] >= scene->mNumMeshes)
			return fail_with(STATUS_INPUT, "%s: a node names surface %u, and there are %u; export the mesh again", told, node->mMeshes[i], scene->mNumMeshes);
		*triangles += scene->mMeshes[node->mMeshes[i]]->mNumFaces;
		if (*triangles > SCENE_MESH_TRIANGLES)
			return too_many(told);
	}
	for (unsigned i = 0; i < node->mNumChildren; i++)
		TRY(count_node(scene, node->mChildren[i], depth + 1, told, triangles, nodes));
	return STATUS_OK;
}

/* Computes the product of two transformations; rows of 4. */
static void product(const double a[3][4], const struct aiMatrix4x4 *b, double out[3][4])
{
	const double rows[4][4] = {{b->a1, b->a2, b->a3, b->a4},
				   {b->b1, b->b2, b->b3, b->b4},
				   {b->c1, b->c2, b->c3, b->c4},
				   {b->d1, b->d2, b->d3, b->d4}};
	for (int i = 0; i < 3; i++)
		for (int k = 0; k < 4; k++)
			out[i][k] = a[i][0] * rows[0][k] + a[i][1] * rows[1][k] + a[i][2] * rows[2][k] + a[i][3] * rows[3][k];
}

static enum status take_mesh(const struct aiMesh *mesh, const double place[3][4], const char *told,
			     uint8_t part, struct mesh_corners *corners)
{
	for (unsigned f = 0; f < mesh->mNumFaces; f++) {
		const struct aiFace *face = &mesh->mFaces[f];
		if (face->mNumIndices != 3)
			continue; /* a point or a line */
		for (int c = 0; c < 3; c++) {
			if (face->mIndices[c] >= mesh->mNumVertices)
				return fail_with(STATUS_INPUT, "%s: a triangle names vertex %u, and there are %u; export the mesh again", told,
						 face->mIndices[c], mesh->mNumVertices);
			const struct aiVector3D *v = &mesh->mVertices[face->mIndices[c]];
			for (int k = 0; k < 3; k++)
				corners->at[3 * corners->triangles + (size_t)c][k] =
					place[k][0] * v->x + place[k][1] * v->y + place[k][2] * v->z + place[k][3];
		}
		if (corners->parts != NULL)
			corners->parts[corners->triangles] = part;
		corners->triangles++;
	}
	return STATUS_OK;
}

/* Returns the part of a material's colour; adds it, or takes the nearest one. */
static uint8_t part_of(const struct aiScene *scene, unsigned material, struct mesh_corners *corners)
{
	struct aiColor4D diffuse = {0.5f, 0.5f, 0.5f, 1};
	struct aiString name = {.length = 0};
	if (corners->parts == NULL)
		return 0;
	if (material < scene->mNumMaterials)
		(void)aiGetMaterialString(scene->mMaterials[material], AI_MATKEY_NAME, &name);
	const bool told = material < scene->mNumMaterials && strcmp(name.data, AI_DEFAULT_MATERIAL_NAME) != 0 &&
			  aiGetMaterialColor(scene->mMaterials[material], AI_MATKEY_COLOR_DIFFUSE, &diffuse) == aiReturn_SUCCESS;
	const float colour[4] = {fminf(fmaxf(diffuse.r, 0), 1), fminf(fmaxf(diffuse.g, 0), 1), fminf(fmaxf(diffuse.b, 0), 1), told};
	size_t nearest = 0;
	float least = INFINITY;
	for (size_t i = 0; i < corners->part_count; i++) {
		float apart = 0;
		for (int k = 0; k < 4; k++)
			apart += (colour[k] - corners->colours[i][k]) * (colour[k] - corners->colours[i][k]);
		if (apart < least) {
			least = apart;
			nearest = i;
		}
	}
	if (least == 0 || corners->part_count == SCENE_MESH_PARTS)
		return (uint8_t)nearest;
	memcpy(corners->colours[corners->part_count], colour, sizeof colour);
	return (uint8_t)corners->part_count++;
}

static enum status take_node(const struct aiScene *scene, const struct aiNode *node, const double above[3][4],
			     const char *told, struct mesh_corners *corners)
{
	double place[3][4];
	product(above, &node->mTransformation, place);
	for (unsigned i = 0; i < node->mNumMeshes; i++)
		TRY(take_mesh(scene->mMeshes[node->mMeshes[i]], (const double(*)[4])place, told, part_of(scene, scene->mMeshes[node->mMeshes[i]]->mMaterialIndex, corners), corners));
	for (unsigned i = 0; i < node->mNumChildren; i++)
		TRY(take_node(scene, node->mChildren[i], (const double(*)[4])place, told, corners));
	return STATUS_OK;
}

static enum status take_scene(const struct aiScene *scene, const char *told, bool coloured, struct mesh_corners *corners)
{
	static const double as_it_is[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
	size_t triangles = 0, nodes = 0;
	TRY(count_node(scene, scene->mRootNode, 0, told, &triangles, &nodes));
	TRY(mem_make(&corners->at, 3 * triangles + 1, sizeof *corners->at, "a mesh"));
	if (coloured) {
		TRY(mem_zeroed(&corners->parts, triangles + 1, sizeof *corners->parts, "a mesh"));
		TRY(mem_zeroed(&corners->colours, SCENE_MESH_PARTS, sizeof *corners->colours, "a mesh"));
	}
	TRY(take_node(scene, scene->mRootNode, as_it_is, told, corners));
	if (corners->triangles == 0)
		return fail_with(STATUS_INPUT, "%s: it has no triangle; needed: a surface of triangles", told);
	return STATUS_OK;
}

/* Fails with one line of assimp's message. The message may contain text of the file, so it is made printable. */
static enum status not_a_mesh(const char *told)
{
	char line[200];
	snprintf(line, sizeof line, "%s", aiGetErrorString());
	line[strcspn(line, "\r\n")] = '\0';
	for (char *at = line; *at != '\0'; at++)
		if (*at < ' ' || *at > '~')
			*at = '?';
	return fail_with(STATUS_INPUT, "%s: it cannot be read as a mesh (%s); give a whole OBJ, STL, DAE or glTF 2 file", told, line);
}

/* All threads share one last error of assimp. So only one thread at a time imports. */
static pthread_mutex_t assimp = PTHREAD_MUTEX_INITIALIZER;

static enum status import(struct given *given, const char *told, bool coloured, struct mesh_corners *corners)
{
	struct aiFileIO io = {open_proc, close_proc, (aiUserData)(void *)given};
	struct aiPropertyStore *properties = aiCreatePropertyStore();
	aiSetImportPropertyInteger(properties, AI_CONFIG_PP_RVC_FLAGS,
				   aiComponent_NORMALS | aiComponent_TANGENTS_AND_BITANGENTS | aiComponent_COLORS |
					   aiComponent_TEXCOORDS | aiComponent_BONEWEIGHTS | aiComponent_ANIMATIONS |
					   aiComponent_TEXTURES | aiComponent_LIGHTS | aiComponent_CAMERAS);
	aiSetImportPropertyInteger(properties, AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, 1); /* as programs for URDF do */
	/* Validation refuses a DAE for two lights of one name. What is read of it is checked here. */
	const unsigned checks = strcmp(given->name, "mesh.dae") == 0 ? 0 : aiProcess_ValidateDataStructure;
	pthread_mutex_lock(&assimp);
	const struct aiScene *scene = aiImportFileExWithProperties(given->name, aiProcess_Triangulate | aiProcess_RemoveComponent | checks, &io, properties);
	aiReleasePropertyStore(properties);
	enum status status = scene == NULL || scene->mRootNode == NULL ? not_a_mesh(told) : STATUS_OK;
	pthread_mutex_unlock(&assimp);
	TRY_OR(done, status);
	TRY_OR(done, take_scene(scene, told, coloured, corners));
done:
	if (scene != NULL)
		aiReleaseImport(scene);
	return status;
}

/* Front is z, left x, up y. */
static enum status import_gltf(const char *path, const char *told, bool packed, const char *bytes, size_t length, struct mesh_corners *corners)
{
	struct scene_gltf gltf;
	enum status status;
	TRY_OR(done, scene_gltf_open(&gltf, path, told, packed, bytes, length));
	TRY_OR(done, scene_gltf_triangles(&gltf, corners));
done:
	scene_gltf_close(&gltf);
	for (size_t i = 0; i < 3 * corners->triangles; i++) {
		const double corner[3] = {corners->at[i][2], corners->at[i][0], corners->at[i][1]};
		memcpy(corners->at[i], corner, sizeof corner);
	}
	return status;
}

struct mesh_kind {
	const char *ending;
	enum status (*count)(const char *bytes, size_t length, const char *told); /* counts the faces of a file before it is read; NULL: glTF, which is counted as it is read */
};

static const struct mesh_kind kinds[] = {
	{".obj", scene_mesh_count_obj}, {".stl", scene_mesh_count_stl}, {".dae", scene_mesh_count_dae}, {".gltf", NULL}, {".glb", NULL}};
#define KINDS_LOOKED_AT 3 /* the first ones: they have parts, and colours beside them */

/* Reads a file of one of the first `count` kinds. *bytes, which is given->bytes: free it if this is STATUS_OK. */
static enum status read_kind(const char *path, const char *told, size_t count, const char *allowed, const struct mesh_kind **kind, struct given *given,
			     char **bytes)
{
	const char *dot = strrchr(path, '.');
	size_t k = 0;
	while (k < count && (dot == NULL || strcasecmp(dot, kinds[k].ending) != 0))
		k++;
	if (k == count)
		return fail_with(STATUS_INPUT, "%s: its name does not say what it is; allowed: %s", told, allowed);
	TRY(scene_file_read(path, told, SCENE_MESH_BYTES, bytes, &given->length));
	snprintf(given->name, sizeof given->name, "mesh%s", kinds[k].ending);
	given->bytes = *bytes;
	*kind = &kinds[k];
	return STATUS_OK;
}

enum status scene_mesh_import(const char *path, const char *told, struct mesh_corners *corners)
{
	const struct mesh_kind *kind = NULL;
	struct given given = {.beside = NULL};
	char *bytes;
	*corners = (struct mesh_corners){0};
	TRY(read_kind(path, told, sizeof kinds / sizeof kinds[0], ".obj, .stl, .dae, .gltf, .glb", &kind, &given, &bytes));
	enum status status;
	if (kind->count != NULL) {
		TRY_OR(done, kind->count(bytes, given.length, told));
		TRY_OR(done, import(&given, told, false, corners));
	} else {
		TRY_OR(done, import_gltf(path, told, strcmp(kind->ending, ".glb") == 0, bytes, given.length, corners));
	}
done:
	mem_free(bytes);
	return status;
}

/* --- files to be looked at --- */

#define MTL_BYTES (1u << 20)

/* Reads the file of materials that an OBJ names, if it lies beside it. Without it the mesh has no colours. */
static void read_materials(const char *path, struct given *given)
{
	static const char word[] = "mtllib ";
	const char *line = strstr(given->bytes, word), *slash = strrchr(path, '/'); /* the bytes end with a NUL */
	char name[sizeof given->beside_name], file[4096];
	if (line == NULL || (line != given->bytes && line[-1] != '\n'))
		return;
	line += sizeof word - 1;
	const size_t length = strcspn(line, "\r\n");
	if (length == 0 || length >= sizeof name || memchr(line, '/', length) != NULL)
		return;
	snprintf(name, sizeof name, "%.*s", (int)length, line);
	if (snprintf(file, sizeof file, "%.*s%s", slash != NULL ? (int)(slash - path + 1) : 0, path, name) >= (int)sizeof file)
		return;
	if (scene_file_read(file, "materials", MTL_BYTES, &given->beside, &given->beside_length) == STATUS_OK)
		memcpy(given->beside_name, name, sizeof name);
	else
		given->beside = NULL;
}

enum status scene_mesh_import_parts(const char *path, const char *told, struct mesh_corners *corners)
{
	const struct mesh_kind *kind = NULL;
	struct given given = {.beside = NULL};
	char *bytes;
	*corners = (struct mesh_corners){0};
	TRY(read_kind(path, told, KINDS_LOOKED_AT, ".obj, .stl, .dae", &kind, &given, &bytes));
	enum status status;
	TRY_OR(done, kind->count(bytes, given.length, told));
	if (kind == kinds)
		read_materials(path, &given);
	TRY_OR(done, import(&given, told, true, corners));
done:
	mem_free_all(bytes, given.beside);
	return status;
}
