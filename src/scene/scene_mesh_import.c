/*
 * Reads mesh files through assimp. It gets bytes and never a path: the file itself, and files that a glTF names in its folder.
 * All together are within SCENE_MESH_BYTES.
 *
 * Only nodes and the triangles of their meshes are used. They are counted before anything is allocated, since nodes may show
 * one mesh many times.
 */
#include "scene/scene_mesh_import.h"

#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "scene/scene_file.h"

#define DEPTH_MAX 256 /* of nodes */

/* The files that one import may open: the mesh file, which was read before, and files in the same folder. */
struct folder {
	const char *path; /* of the mesh file */
	char name[16];    /* name of the mesh file that assimp is told, in place of its path */
	const char *bytes; /* the content of the mesh file */
	size_t length, left; /* bytes of it; bytes that other files may still have */
};

struct open_file {
	struct aiFile file;
	char *owned; /* the content, freed when the file is closed; NULL: this is the mesh file, whose content the folder has */
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

/* Returns true if this is a file name without a folder. */
static bool is_beside(const char *name)
{
	return name[0] != '\0' && name[0] != '.' && strpbrk(name, "/\\:") == NULL;
}

static struct aiFile *open_proc(struct aiFileIO *io, const char *name, const char *mode)
{
	struct folder *folder = (struct folder *)(void *)io->UserData;
	struct open_file *open = mem_calloc(1, sizeof *open);
	if (open == NULL)
		return NULL;
	if (strncmp(name, "./", 2) == 0)
		name += 2;
	if (strcmp(name, folder->name) == 0) {
		open->bytes = folder->bytes;
		open->length = folder->length;
	} else {
		char *path = is_beside(name) ? scene_file_beside(folder->path, name) : NULL;
		enum status status = path != NULL ? scene_file_read(path, name, folder->left, &open->owned, &open->length)
						  : STATUS_INPUT;
		mem_free(path);
		if (status != STATUS_OK) {
			mem_free(open);
			return NULL;
		}
		folder->left -= open->length;
		open->bytes = open->owned;
	}
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
	mem_free(open->owned);
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
		*triangles += scene->mMeshes[node->mMeshes[i]]->mNumFaces;
		if (*triangles > SCENE_MESH_TRIANGLES)
			return too_many(told);
	}
	enum status status = STATUS_OK;
	for (unsigned i = 0; i < node->mNumChildren && status == STATUS_OK; i++)
		status = count_node(scene, node->mChildren[i], depth + 1, told, triangles, nodes);
	return status;
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
			     struct mesh_corners *corners)
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
		corners->triangles++;
	}
	return STATUS_OK;
}

static enum status take_node(const struct aiScene *scene, const struct aiNode *node, const double above[3][4],
			     const char *told, struct mesh_corners *corners)
{
	enum status status = STATUS_OK;
	double place[3][4];
	product(above, &node->mTransformation, place);
	for (unsigned i = 0; i < node->mNumMeshes && status == STATUS_OK; i++)
		status = take_mesh(scene->mMeshes[node->mMeshes[i]], (const double(*)[4])place, told, corners);
	for (unsigned i = 0; i < node->mNumChildren && status == STATUS_OK; i++)
		status = take_node(scene, node->mChildren[i], (const double(*)[4])place, told, corners);
	return status;
}

static enum status take_scene(const struct aiScene *scene, bool gltf, const char *told, struct mesh_corners *corners)
{
	static const double as_it_is[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
	static const double front_is_z[3][4] = {{0, 0, 1, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}};
	size_t triangles = 0, nodes = 0;
	enum status status = count_node(scene, scene->mRootNode, 0, told, &triangles, &nodes);
	if (status != STATUS_OK)
		return status;
	corners->at = mem_alloc(3 * triangles + 1, sizeof *corners->at);
	if (corners->at == NULL)
		return fail_memory("a mesh");
	status = take_node(scene, scene->mRootNode, gltf ? front_is_z : as_it_is, told, corners);
	if (status == STATUS_OK && corners->triangles == 0)
		status = fail_with(STATUS_INPUT, "%s: it has no triangle; needed: a surface of triangles", told);
	return status;
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
	return fail_with(STATUS_INPUT, "%s: it cannot be read as a mesh (%s); give a whole OBJ, STL or glTF 2 file", told, line);
}

/* All threads share one last error of assimp. So only one thread at a time imports. */
static pthread_mutex_t assimp = PTHREAD_MUTEX_INITIALIZER;

static enum status import(struct folder *folder, bool gltf, const char *told, struct mesh_corners *corners)
{
	struct aiFileIO io = {open_proc, close_proc, (aiUserData)(void *)folder};
	struct aiPropertyStore *properties = aiCreatePropertyStore();
	aiSetImportPropertyInteger(properties, AI_CONFIG_PP_RVC_FLAGS,
				   aiComponent_NORMALS | aiComponent_TANGENTS_AND_BITANGENTS | aiComponent_COLORS |
					   aiComponent_TEXCOORDS | aiComponent_BONEWEIGHTS | aiComponent_ANIMATIONS |
					   aiComponent_TEXTURES | aiComponent_LIGHTS | aiComponent_CAMERAS);
	pthread_mutex_lock(&assimp);
	const struct aiScene *scene = aiImportFileExWithProperties(
		folder->name, aiProcess_Triangulate | aiProcess_RemoveComponent | aiProcess_ValidateDataStructure, &io,
		properties);
	aiReleasePropertyStore(properties);
	enum status status = STATUS_OK;
	if (scene == NULL || scene->mRootNode == NULL)
		status = not_a_mesh(told);
	pthread_mutex_unlock(&assimp);
	if (status == STATUS_OK)
		status = take_scene(scene, gltf, told, corners);
	if (scene != NULL)
		aiReleaseImport(scene);
	return status;
}

enum status scene_mesh_import(const char *path, const char *told, struct mesh_corners *corners)
{
	static const char *const endings[] = {".obj", ".stl", ".gltf", ".glb"};
	const char *dot = strrchr(path, '.'), *ending = NULL;
	struct folder folder = {.path = path};
	char *bytes;
	*corners = (struct mesh_corners){0};
	for (size_t i = 0; i < sizeof endings / sizeof *endings && dot != NULL; i++)
		if (strcasecmp(dot, endings[i]) == 0)
			ending = endings[i];
	if (ending == NULL)
		return fail_with(STATUS_INPUT, "%s: its name does not say what it is; allowed: .obj, .stl, .gltf, .glb", told);
	enum status status = scene_file_read(path, told, SCENE_MESH_BYTES, &bytes, &folder.length);
	if (status != STATUS_OK)
		return status;
	snprintf(folder.name, sizeof folder.name, "mesh%s", ending);
	folder.bytes = bytes;
	folder.left = SCENE_MESH_BYTES - folder.length;
	status = import(&folder, ending[1] == 'g', told, corners);
	mem_free(bytes);
	return status;
}
