/*
 * path: the light that one random path from the eye finds.
 *
 * Unbiased: next-event estimation and BSDF sampling, joined by multiple importance sampling, ended by Russian roulette.
 *
 * SPDX-License-Identifier: BSD-3-Clause
 */
#include "path.h"

#include <stdlib.h>

static const double PI = 3.14159265358979323846;
static const double RAY_OFFSET = 1e-6; /* keeps a ray from meeting the surface that it leaves */

/* ---- Frames ---- */

/* An orthonormal basis; local coordinates have the normal as z. */
typedef struct {
    Vec tangent, bitangent, normal;
} Frame;

/* Duff et al. 2017, Building an Orthonormal Basis, Revisited. */
static Frame frame_around(Vec n) {
    double sign = copysign(1, n.z), a = -1 / (sign + n.z), b = n.x * n.y * a;
    return (Frame){vec(1 + sign * n.x * n.x * a, sign * b, -sign * n.x), vec(b, sign + n.y * n.y * a, -n.y), n};
}

static Vec to_local(const Frame *f, Vec v) {
    return vec(dot(v, f->tangent), dot(v, f->bitangent), dot(v, f->normal));
}

static Vec to_world(const Frame *f, Vec v) {
    return add(add(scale(f->tangent, v.x), scale(f->bitangent, v.y)), scale(f->normal, v.z));
}

/* ---- Random numbers ---- */

/* The finaliser of SplitMix64: Steele et al. 2014, Fast Splittable Pseudorandom Number Generators. */
static uint64_t hash(uint64_t x) {
    x += 0x9e3779b97f4a7c15;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9;
    x = (x ^ x >> 27) * 0x94d049bb133111eb;
    return x ^ x >> 31;
}

Random random_stream(uint64_t seed, uint64_t pixel, uint64_t sample) {
    uint64_t name = hash(hash(hash(seed) ^ pixel) ^ sample);
    return (Random){name, hash(name) | 1};
}

/* PCG-XSH-RR: O'Neill 2014, PCG: A Family of Simple Fast Space-Efficient ... Algorithms. */
double uniform(Random *random) {
    uint64_t old = random->state;
    random->state = old * 6364136223846793005 + random->increment;
    uint32_t shifted = (uint32_t)((old >> 18 ^ old) >> 27), rotation = (uint32_t)(old >> 59);
    return (shifted >> rotation | shifted << (-rotation & 31)) * 0x1p-32;
}

/* ---- Intersection ---- */

typedef struct {
    double distance;
    const Primitive *primitive; /* NULL: the ray leaves the scene */
    Vec point, normal;          /* the normal of the ray's side */
    bool inside;                /* the ray comes from within a sphere or box */
} Hit;

static bool hit_sphere(const Primitive *sphere, const Ray *ray, Hit *hit) {
    Vec to_centre = sub(sphere->a, ray->origin);
    double middle = dot(to_centre, ray->direction);
    Vec closest = sub(scale(ray->direction, middle), to_centre);
    double discriminant = sphere->b.x * sphere->b.x - dot(closest, closest);
    if (discriminant < 0) return false;
    double half_chord = sqrt(discriminant);
    bool inside = middle - half_chord < RAY_OFFSET;
    double distance = inside ? middle + half_chord : middle - half_chord;
    if (distance < RAY_OFFSET || distance >= hit->distance) return false;
    Vec normal = normalise(add(closest, scale(ray->direction, distance - middle)));
    *hit = (Hit){.distance = distance, .primitive = sphere, .normal = normal, .inside = inside};
    return true;
}

static double lower(double a, double b) {
    return a < b ? a : b;
}

static double higher(double a, double b) {
    return a > b ? a : b;
}

/* Slab by slab: Kay & Kajiya 1986, Ray Tracing Complex Scenes. */
static bool hit_box(const Primitive *box, const Ray *ray, Hit *hit) {
    Vec t0 = mul(sub(box->a, ray->origin), ray->inverse), t1 = mul(sub(box->b, ray->origin), ray->inverse);
    Vec near = vec(lower(t0.x, t1.x), lower(t0.y, t1.y), lower(t0.z, t1.z));
    Vec far = vec(higher(t0.x, t1.x), higher(t0.y, t1.y), higher(t0.z, t1.z));
    double enter = higher(near.x, higher(near.y, near.z)), leave = lower(far.x, lower(far.y, far.z));
    bool inside = enter < RAY_OFFSET;
    double distance = inside ? leave : enter;
    if (enter > leave || distance < RAY_OFFSET || distance >= hit->distance) return false;
    Vec planes = inside ? far : near;
    Vec normal = planes.x == distance ? vec(1, 0, 0) : planes.y == distance ? vec(0, 1, 0) : vec(0, 0, 1);
    *hit = (Hit){.distance = distance, .primitive = box, .normal = normal, .inside = inside};
    return true;
}

static bool hit_quad(const Primitive *quad, const Ray *ray, Hit *hit) {
    Vec normal = cross(quad->b, quad->c);
    double area_squared = dot(normal, normal);
    double distance = dot(sub(quad->a, ray->origin), normal) / dot(ray->direction, normal);
    if (!(distance >= RAY_OFFSET && distance < hit->distance)) /* a parallel ray gives NaN or infinity */
        return false;
    Vec within = sub(add(ray->origin, scale(ray->direction, distance)), quad->a);
    double u = dot(cross(within, quad->c), normal) / area_squared;
    double v = dot(cross(quad->b, within), normal) / area_squared;
    if (u < 0 || u > 1 || v < 0 || v > 1) return false;
    *hit = (Hit){.distance = distance, .primitive = quad, .normal = scale(normal, 1 / sqrt(area_squared))};
    return true;
}

static bool hit_primitive(const Primitive *primitive, const Ray *ray, Hit *hit) {
    switch (primitive->shape) {
    case SPHERE:
        return hit_sphere(primitive, ray, hit);
    case BOX:
        return hit_box(primitive, ray, hit);
    case QUAD:
        return hit_quad(primitive, ray, hit);
    }
    return false;
}

Ray ray_from(Vec origin, Vec direction) {
    return (Ray){origin, direction, vec(1 / direction.x, 1 / direction.y, 1 / direction.z)};
}

static Hit nearest_hit(const Scene *scene, const Ray *ray) {
    Hit hit = {.distance = INFINITY};
    for (int i = 0; i < scene->primitive_count; i++)
        if (scene->primitives[i].material.kind != PORTAL) hit_primitive(&scene->primitives[i], ray, &hit);
    if (hit.primitive) {
        hit.point = add(ray->origin, scale(ray->direction, hit.distance));
        if (dot(hit.normal, ray->direction) > 0) hit.normal = scale(hit.normal, -1);
    }
    return hit;
}

/* ---- Scattering, in local coordinates: out is where the path came from, in is where its light comes from ---- */

typedef struct {
    Vec in;
    Vec weight;     /* BSDF * cosine / density */
    double density; /* over solid angle; 0: the direction had no choice (mirror, glass) */
} Scatter;

/* Schlick 1994, An Inexpensive BRDF Model for Physically-based Rendering. */
static Vec fresnel_conductor(Vec normal_reflectance, double cosine) {
    return mix(normal_reflectance, vec(1, 1, 1), pow(1 - cosine, 5));
}

/* Born & Wolf, Principles of Optics, section 1.5.2, for unpolarised light. ratio: index of in's side over out's. */
static double fresnel_dielectric(double cosine, double cosine_refracted, double ratio) {
    double parallel = (ratio * cosine - cosine_refracted) / (ratio * cosine + cosine_refracted);
    double perpendicular = (cosine - ratio * cosine_refracted) / (cosine + ratio * cosine_refracted);
    return (parallel * parallel + perpendicular * perpendicular) / 2;
}

/* Walter et al. 2007, Microfacet Models for Refraction through Rough Surfaces, equation 33. */
static double ggx_distribution(Vec half, double alpha) {
    double d = 1 + half.z * half.z * (alpha * alpha - 1);
    return alpha * alpha / (PI * d * d);
}

/* Heitz 2014, Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs, equation 72. */
static double smith_lambda(Vec v, double alpha) {
    double tangent_squared = (v.x * v.x + v.y * v.y) / (v.z * v.z);
    return (sqrt(1 + alpha * alpha * tangent_squared) - 1) / 2;
}

/* Heitz 2018, Sampling the GGX Distribution of Visible Normals, appendix A. */
static Vec sample_visible_normal(Vec out, double alpha, Random *random) {
    double u1 = uniform(random), u2 = uniform(random);
    Vec stretched = normalise(vec(alpha * out.x, alpha * out.y, out.z));
    double length_squared = stretched.x * stretched.x + stretched.y * stretched.y;
    Vec t1 = length_squared > 0 ? scale(vec(-stretched.y, stretched.x, 0), 1 / sqrt(length_squared)) : vec(1, 0, 0);
    Vec t2 = cross(stretched, t1);
    double r = sqrt(u1), p1 = r * cos(2 * PI * u2), s = (1 + stretched.z) / 2;
    double p2 = (1 - s) * sqrt(1 - p1 * p1) + s * r * sin(2 * PI * u2);
    double p3 = sqrt(fmax(0, 1 - p1 * p1 - p2 * p2));
    Vec n = add(add(scale(t1, p1), scale(t2, p2)), scale(stretched, p3));
    return normalise(vec(alpha * n.x, alpha * n.y, fmax(1e-9, n.z)));
}

/* BSDF * cosine of a surface that is not specular, and the density with which sample_bsdf would choose in. */
static Vec evaluate_bsdf(const Material *material, Vec albedo, Vec out, Vec in, double *density) {
    *density = 0;
    if (in.z <= 0 || out.z <= 0) return vec(0, 0, 0);
    if (material->kind == DIFFUSE) {
        *density = in.z / PI;
        return scale(albedo, in.z / PI);
    }
    Vec half = normalise(add(out, in));
    double alpha = material->parameter;
    double lambda_out = smith_lambda(out, alpha), lambda_in = smith_lambda(in, alpha);
    double peak = ggx_distribution(half, alpha) / (4 * out.z);
    *density = peak / (1 + lambda_out);
    return scale(fresnel_conductor(albedo, dot(out, half)), peak / (1 + lambda_out + lambda_in));
}

/*
 * Smooth glass: reflects or refracts, chosen by the Fresnel reflectance. The factor 1/ratio^2 of refracted radiance is
 * left out: no light source is inside glass, so what one face would take the other gives back.
 */
static Scatter sample_glass(double index, bool inside, Vec out, Random *random) {
    double ratio = inside ? 1 / index : index;
    double cosine_squared = 1 - (1 - out.z * out.z) / (ratio * ratio);
    double refracted = sqrt(fmax(0, cosine_squared));
    double reflectance = cosine_squared <= 0 ? 1 : fresnel_dielectric(out.z, refracted, ratio);
    bool reflects = uniform(random) < reflectance;
    Vec in = reflects ? vec(-out.x, -out.y, out.z) : vec(-out.x / ratio, -out.y / ratio, -refracted);
    return (Scatter){.in = in, .weight = vec(1, 1, 1)};
}

static Scatter sample_bsdf(const Material *material, Vec albedo, bool inside, Vec out, Random *random) {
    if (material->kind == GLASS) return sample_glass(material->parameter, inside, out, random);
    if (material->kind == MIRROR) return (Scatter){.in = vec(-out.x, -out.y, out.z), .weight = albedo};
    Scatter scatter;
    if (material->kind == CONDUCTOR) {
        Vec half = sample_visible_normal(out, material->parameter, random);
        scatter.in = sub(scale(half, 2 * dot(out, half)), out);
    } else {
        double r = sqrt(uniform(random)), angle = 2 * PI * uniform(random);
        scatter.in = vec(r * cos(angle), r * sin(angle), sqrt(1 - r * r));
    }
    Vec value = evaluate_bsdf(material, albedo, out, scatter.in, &scatter.density);
    scatter.weight = scatter.density > 0 ? scale(value, 1 / scatter.density) : vec(0, 0, 0);
    return scatter;
}

/* A tile's shade is drawn from its position; each row of tiles is shifted against the one before. */
static Vec albedo_at(const Material *material, Vec point) {
    if (material->tile.x == 0) return material->colour;
    double column = floor(point.x / material->tile.x);
    double row = floor(point.z / material->tile.z + 0.382 * column);
    Random shade = random_stream(1, (uint64_t)(int64_t)column, (uint64_t)(int64_t)row);
    return scale(material->colour, 0.6 + 0.4 * uniform(&shade));
}

/* ---- Light ---- */

static Vec sky(const Scene *scene, Vec direction) {
    return direction.y > 0 ? mix(scene->horizon, scene->zenith, sqrt(direction.y)) : scene->ground;
}

/* What the ray sees shining at its end: an emitter, the sky, or nothing. */
static Vec emitted(const Scene *scene, const Ray *ray, const Hit *hit) {
    if (!hit->primitive) return sky(scene, ray->direction);
    return hit->primitive->material.kind == EMITTER ? hit->primitive->material.colour : vec(0, 0, 0);
}

/*
 * The gas along the ray, up to its end. Its density falls from the middle of the ball as (1 - r^2/R^2)^2; with s
 * counted from the point of the ray nearest to the middle, and h half the chord, that is (h^2 - s^2)^2 / R^4.
 */
static Vec glow_along(const Scene *scene, const Ray *ray, double end) {
    Vec to_centre = sub(scene->glow_centre, ray->origin);
    double middle = dot(to_centre, ray->direction), radius = scene->glow_radius;
    double h_squared = radius * radius - dot(to_centre, to_centre) + middle * middle;
    if (h_squared <= 0) return vec(0, 0, 0);
    double h = sqrt(h_squared), first = fmax(-middle, -h), last = fmin(end - middle, h);
    if (first >= last) return vec(0, 0, 0);
    double integral = 0;
    for (int side = 0; side < 2; side++) {
        double s = side ? last : first;
        double primitive = s * (h_squared * h_squared - s * s * (2 * h_squared / 3 - s * s / 5));
        integral += side ? primitive : -primitive;
    }
    double through_middle = pow(radius, 5) * 16 / 15;
    return scale(scene->glow, integral / through_middle);
}

/* 1 - cos of the half angle of the cone in which a sphere is seen; 0 from inside. Exact for small angles too. */
static double sphere_cap(const Primitive *sphere, Vec point) {
    Vec to_centre = sub(sphere->a, point);
    double sine_squared = sphere->b.x * sphere->b.x / dot(to_centre, to_centre);
    return sine_squared < 1 ? sine_squared / (1 + sqrt(1 - sine_squared)) : 0;
}

/* Density over solid angle with which sample_light would take this light and this ray's direction. */
static double light_density(const Scene *scene, const Primitive *light, const Ray *ray) {
    Hit hit = {.distance = INFINITY};
    if (!hit_primitive(light, ray, &hit)) return 0;
    double density;
    if (light->shape == SPHERE) {
        double cap = sphere_cap(light, ray->origin);
        density = cap > 0 ? 1 / (2 * PI * cap) : 0;
    } else {
        double area = length(cross(light->b, light->c));
        density = hit.distance * hit.distance / (fabs(dot(hit.normal, ray->direction)) * area);
    }
    return density / scene->light_count;
}

/* The density with which next-event estimation would have chosen this ray for what it sees shining at its end. */
static double competing_density(const Scene *scene, const Ray *ray, const Hit *hit) {
    if (hit->primitive) return light_density(scene, hit->primitive, ray);
    double density = 0;
    for (int i = 0; i < scene->light_count; i++) {
        const Primitive *light = &scene->primitives[scene->lights[i]];
        density += light->material.kind == PORTAL ? light_density(scene, light, ray) : 0;
    }
    return density;
}

/* A direction from the point to the light: uniform in the cone of a sphere, uniform over the area of a quad. */
static Vec sample_light(const Primitive *light, Vec point, Random *random) {
    double u1 = uniform(random), u2 = uniform(random);
    if (light->shape == QUAD)
        return normalise(sub(add(light->a, add(scale(light->b, u1), scale(light->c, u2))), point));
    /* Shirley et al. 1996, Monte Carlo Techniques for Direct Lighting Calculations. */
    Frame frame = frame_around(normalise(sub(light->a, point)));
    double drop = u1 * sphere_cap(light, point), sine = sqrt(drop * (2 - drop));
    return to_world(&frame, vec(sine * cos(2 * PI * u2), sine * sin(2 * PI * u2), 1 - drop));
}

/* The power heuristic: Veach & Guibas 1995, Optimally Combining Sampling Techniques for Monte Carlo Rendering. */
static double power_heuristic(double density, double other) {
    double ratio = other / density;
    return 1 / (1 + ratio * ratio);
}

/* Next-event estimation: light that comes straight from one light, chosen evenly, and is scattered to out. */
static Vec direct_light(const Scene *scene, const Hit *hit, const Frame *frame, Vec albedo, Vec out, Random *random) {
    if (scene->light_count == 0) return vec(0, 0, 0);
    int choice = (int)(uniform(random) * scene->light_count);
    const Primitive *light = &scene->primitives[scene->lights[choice]];
    Ray ray = ray_from(hit->point, sample_light(light, hit->point, random));
    double scatter_density, density = light_density(scene, light, &ray);
    Vec in = to_local(frame, ray.direction);
    Vec scattered = evaluate_bsdf(&hit->primitive->material, albedo, out, in, &scatter_density);
    if (!(density > 0) || !(scatter_density > 0)) return vec(0, 0, 0);
    Hit seen = nearest_hit(scene, &ray);
    if (seen.primitive != (light->material.kind == PORTAL ? NULL : light)) return vec(0, 0, 0);
    Vec light_radiance = emitted(scene, &ray, &seen);
    return scale(mul(scattered, light_radiance), power_heuristic(density, scatter_density) / density);
}

/* ---- Paths ---- */

enum { SURE_BOUNCES = 4 };

Vec trace_path(const Scene *scene, Ray ray, Random *random, bool *covered) {
    Vec radiance = vec(0, 0, 0), throughput = vec(1, 1, 1);
    double density = 0; /* of the ray's direction; 0: it had no choice, so no other way of sampling competes */
    for (int bounce = 0;; bounce++) {
        Hit hit = nearest_hit(scene, &ray);
        if (bounce == 0) *covered = hit.primitive != NULL;
        radiance = add(radiance, mul(throughput, glow_along(scene, &ray, hit.distance)));
        if (!hit.primitive || hit.primitive->material.kind == EMITTER) {
            double weight = density > 0 ? power_heuristic(density, competing_density(scene, &ray, &hit)) : 1;
            return add(radiance, scale(mul(throughput, emitted(scene, &ray, &hit)), weight));
        }
        const Material *material = &hit.primitive->material;
        Frame frame = frame_around(hit.normal);
        Vec out = to_local(&frame, scale(ray.direction, -1)), albedo = albedo_at(material, hit.point);
        if (material->kind == DIFFUSE || material->kind == CONDUCTOR)
            radiance = add(radiance, mul(throughput, direct_light(scene, &hit, &frame, albedo, out, random)));
        Scatter scatter = sample_bsdf(material, albedo, hit.inside, out, random);
        throughput = mul(throughput, scatter.weight);
        double survival = bounce < SURE_BOUNCES ? 1 : fmin(0.95, largest(throughput));
        if (largest(throughput) <= 0 || uniform(random) >= survival) return radiance;
        throughput = scale(throughput, 1 / survival);
        density = scatter.density;
        ray = ray_from(hit.point, to_world(&frame, scatter.in));
    }
}
