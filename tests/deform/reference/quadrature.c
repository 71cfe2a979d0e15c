/* Adaptive integrals by the rule of Gauss and Kronrod. */
#include <math.h>
#include <stdbool.h>

#include "deform/reference/quadrature.h"

#define HALVINGS 30

/* Nodes of Kronrod's rule in 0 .. 1, and their weights. Every second node is one of Gauss's. */
static const double nodes[8] = {
	0.991455371120812639206854697526329, 0.949107912342758524526189684047851, 0.864864423359769072789712788640926,
	0.741531185599394439863864773280788, 0.586087235467691130294144691693829, 0.405845151377397166906606412076961,
	0.207784955007898467600689403773245, 0,
};
static const double kronrod[8] = {
	0.022935322010529224963732008058970, 0.063092092629978553290700663189204, 0.104790010322250183839876322541518,
	0.140653259715525918745189590510238, 0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
	0.204432940075298892414161999234649, 0.209482141084727828012999174891714,
};
static const double gauss[4] = {
	0.129484966168869693270611432679082, 0.279705391489276667901467771423780, 0.381830050505118944950369775488975,
	0.417959183673469387755102040816327,
};

struct task {
	quadrature_function function;
	const void *user;
	double *sums;
};

static void add_piece(const struct task *task, double from, double to, double tolerance, int halvings)
{
	double middle = (from + to) / 2, half = (to - from) / 2;
	double fine[QUADRATURE_MOST] = {0}, coarse[QUADRATURE_MOST] = {0}, values[QUADRATURE_MOST];
	for (int i = 0; i < 8; i++)
		for (int side = i < 7 ? -1 : 1; side <= 1; side += 2) {
			task->function(task->user, middle + side * half * nodes[i], values);
			for (int v = 0; v < QUADRATURE_MOST; v++) {
				fine[v] += half * kronrod[i] * values[v];
				coarse[v] += i % 2 == 1 ? half * gauss[i / 2] * values[v] : 0;
			}
		}
	bool agree = true;
	for (int v = 0; v < QUADRATURE_MOST; v++)
		agree = agree && !(fabs(fine[v] - coarse[v]) > tolerance);
	if (!agree && halvings > 0) {
		add_piece(task, from, middle, tolerance / 2, halvings - 1);
		add_piece(task, middle, to, tolerance / 2, halvings - 1);
		return;
	}
	for (int v = 0; v < QUADRATURE_MOST; v++)
		task->sums[v] += fine[v];
}

void quadrature_add(quadrature_function function, const void *user, double from, double to, double tolerance, double *sums)
{
	struct task task = {function, user, sums};
	if (to > from)
		add_piece(&task, from, to, tolerance, HALVINGS);
}
