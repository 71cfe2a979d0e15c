/* Meshes as another library reads them: assimp finds the triangles, places and bounds that were told, in each format. */
#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include "exchange/exchange.h"
#include "support.h"
#include "../support/program.h"

#define CELLS 32

static double waves(int64_t x, int64_t y)
{
	bool hole = x >= 20 && x < 24 && y >= 30 && y < 37;
	return hole ? (double)NAN : 1500 + 4 * sin((double)x / 7) + 3 * cos((double)y / 5);
}

struct read {
	uint64_t triangles;
	double low[3], high[3], volume; /* volume: between the surface and height 0 of the mesh, seen along `up` */
};

/* Sums the prisms below the triangles. `up`: the axis that is up; the others follow it in the cyclic order. */
static struct read read_mesh(const char *path, int up)
{
	struct read read = {.low = {INFINITY, INFINITY, INFINITY}, .high = {-INFINITY, -INFINITY, -INFINITY}};
	const struct aiScene *scene = aiImportFile(path, aiProcess_ValidateDataStructure);
	if (scene == NULL)
		print_error("%s\n", aiGetErrorString());
	assert_non_null(scene);
	assert_int_equal(scene->mNumMeshes, 1);
	const struct aiMesh *mesh = scene->mMeshes[0];
	read.triangles = mesh->mNumFaces;
	for (unsigned k = 0; k < mesh->mNumFaces; k++) {
		double p[3][3], height = 0;
		assert_int_equal(mesh->mFaces[k].mNumIndices, 3);
		for (int i = 0; i < 3; i++) {
			const struct aiVector3D *v = &mesh->mVertices[mesh->mFaces[k].mIndices[i]];
			p[i][0] = (double)v->x;
			p[i][1] = (double)v->y;
			p[i][2] = (double)v->z;
			height += p[i][up] / 3;
			for (int c = 0; c < 3; c++) {
				read.low[c] = fmin(read.low[c], p[i][c]);
				read.high[c] = fmax(read.high[c], p[i][c]);
			}
		}
		int a = (up + 1) % 3, b = (up + 2) % 3;
		double area = ((p[1][a] - p[0][a]) * (p[2][b] - p[0][b]) - (p[2][a] - p[0][a]) * (p[1][b] - p[0][b])) / 2;
		assert_true(area > 0); /* counter-clockwise from above */
		read.volume += area * height;
	}
	aiReleaseImport(scene);
	return read;
}

/* The volume below the same triangles, from the heights themselves. */
static double true_volume(struct post_rect rect, double spacing, double origin, uint64_t *triangles)
{
	static const int whole[2][3] = {{0, 1, 2}, {2, 1, 3}}, without[4][3] = {{2, 1, 3}, {0, 3, 2}, {0, 1, 3}, {0, 1, 2}};
	double volume = 0;
	*triangles = 0;
	for (int64_t y = rect.y0; y + 1 < rect.y1; y++)
		for (int64_t x = rect.x0; x + 1 < rect.x1; x++) {
			double h[4];
			int holes = 0, hole = 0;
			for (int k = 0; k < 4; k++) {
				h[k] = round(1024 * waves(x + k % 2, y + k / 2)) / 1024 - origin;
				hole = isnan(h[k]) ? k : hole;
				holes += isnan(h[k]);
			}
			for (int t = 0; t < 2 - holes; t++) {
				const int *corner = holes == 1 ? without[hole] : whole[t];
				volume += spacing * spacing / 2 * (h[corner[0]] + h[corner[1]] + h[corner[2]]) / 3;
				++*triangles;
			}
		}
	return volume;
}

static void assimp_reads_what_was_told(void **state)
{
	static const double spacings[] = {0.05, 1, 30};
	static const struct {
		const char *name;
		enum exchange_up up;
		bool y_up;
	} files[] = {{"m.obj", EXCHANGE_UP_FORMAT, true}, {"m.obj", EXCHANGE_UP_Z, false}, {"m.stl", EXCHANGE_UP_FORMAT, false},
		     {"m.stl", EXCHANGE_UP_Y, true}, {"m.glb", EXCHANGE_UP_FORMAT, true}, {"m.glb", EXCHANGE_UP_Y, true}};
	for (size_t i = 0; i < 3; i++) {
		const char *path = support_path("mesh.furrow");
		support_store(path, (struct extent){97, 70, spacings[i], CELLS}, waves);
		struct store *store;
		struct store_reader *reader;
		must(store_open(path, &(struct store_options){.mode = STORE_READ}, &store));
		must(store_reader_create(store, &reader));
		for (size_t k = 0; k < sizeof files / sizeof *files; k++) {
			struct post_rect rect = {5, 3, 90, 69};
			struct exchange_mesh_params params = {.reader = reader, .meta = store_meta(store), .path = support_path(files[k].name), .rect = rect,
				.up = files[k].up};
			struct exchange_mesh_result told;
			must(exchange_mesh(&params, &told));
			const bool y_up = files[k].y_up;
			assert_int_equal(told.y_up, y_up);
			struct read read = read_mesh(params.path, y_up ? 1 : 2);
			uint64_t triangles;
			double volume = true_volume(rect, spacings[i], told.origin[2], &triangles);
			assert_int_equal(told.triangles, triangles);
			assert_int_equal(read.triangles, triangles);
			double size = 85 * 66 * spacings[i] * spacings[i];
			assert_true(fabs(read.volume - volume) < 1e-5 * (volume + size));
			assert_true(told.origin[0] == 5 * spacings[i] && told.origin[1] == 3 * spacings[i]);
			const double low[] = {told.low[0], y_up ? told.low[2] : told.low[1], y_up ? -told.high[1] : told.low[2]};
			const double high[] = {told.high[0], y_up ? told.high[2] : told.high[1], y_up ? -told.low[1] : told.high[2]};
			for (int c = 0; c < 3; c++) {
				assert_true(fabs(read.low[c] - low[c]) < 1e-6 * (1 + fabs(low[c])));
				assert_true(fabs(read.high[c] - high[c]) < 1e-6 * (1 + fabs(high[c])));
			}
		}
		store_reader_destroy(reader);
		store_close(store);
		unlink(path);
	}
}

TEST_PROGRAM(meshes)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(assimp_reads_what_was_told)};
	return cmocka_run_group_tests(tests, support_enter, support_leave);
}
