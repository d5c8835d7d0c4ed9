// Traces the rays that neumann-core's example `rays` wrote, through Embree 3: robust, single rays, one thread.
// Prints the same line of JSON.
//
//     g++ -O3 -march=native embree.cpp -lembree3 -o embree && ./embree FILE [ROUNDS]
#include <embree3/rtcore.h>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <vector>

static double thread_seconds() {
    timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return t.tv_sec + t.tv_nsec * 1e-9;
}

struct Ray { float origin[3], direction[3], length; };

static RTCRay prepared(const Ray& from) {
    RTCRay ray;
    ray.org_x = from.origin[0]; ray.org_y = from.origin[1]; ray.org_z = from.origin[2];
    ray.dir_x = from.direction[0]; ray.dir_y = from.direction[1]; ray.dir_z = from.direction[2];
    ray.tnear = 0; ray.tfar = from.length; ray.time = 0;
    ray.mask = ~0u; ray.id = 0; ray.flags = 0;
    return ray;
}

// A scene of high quality, and the seconds that it took to build.
static RTCScene built(RTCDevice device, RTCSceneFlags flags, const std::vector<float>& corners, double& seconds) {
    const uint32_t n = corners.size() / 9;
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, flags);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
    float* positions = (float*)rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, size_t(n) * 3);
    uint32_t* indices = (uint32_t*)rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, n);
    for (size_t i = 0; i < corners.size(); i++) positions[i] = corners[i];
    for (uint32_t i = 0; i < n * 3; i++) indices[i] = i;
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    const auto start = std::chrono::steady_clock::now();
    rtcCommitScene(scene);
    seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return scene;
}

int main(int argc, char** argv) {
    if (argc < 2) { std::fprintf(stderr, "usage: embree FILE [ROUNDS]\n"); return 2; }
    const int rounds = argc > 2 ? std::atoi(argv[2]) : 1;
    std::FILE* file = std::fopen(argv[1], "rb");
    if (!file) { std::perror(argv[1]); return 2; }
    uint32_t n[4];
    bool is_whole = std::fread(n, 4, 4, file) == 4;
    std::vector<float> corners(size_t(n[0]) * 9);
    is_whole = is_whole && std::fread(corners.data(), 36, n[0], file) == n[0];
    std::vector<Ray> rays[3];
    for (int kind = 0; kind < 3; kind++) {
        rays[kind].resize(n[kind + 1]);
        is_whole = is_whole && std::fread(rays[kind].data(), sizeof(Ray), n[kind + 1], file) == n[kind + 1];
    }
    if (!is_whole) { std::fprintf(stderr, "%s: ends early\n", argv[1]); return 2; }

    RTCDevice device = rtcNewDevice(nullptr);
    double build[2];
    // The rays go through the robust scene; the other one, whose high quality splits triangles, is only built.
    RTCScene fast = built(device, RTC_SCENE_FLAG_NONE, corners, build[0]);
    rtcReleaseScene(fast);
    RTCScene scene = built(device, RTC_SCENE_FLAG_ROBUST, corners, build[1]);

    for (int round = 0; round < rounds; round++) {
        double speed[3];
        size_t hits[3];
        for (int kind = 0; kind < 3; kind++) {
            RTCIntersectContext context;
            rtcInitIntersectContext(&context);
            if (kind == 1) context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
            hits[kind] = 0;
            const double begin = thread_seconds();
            for (const Ray& from : rays[kind]) {
                if (kind == 2) {
                    RTCRay ray = prepared(from);
                    rtcOccluded1(scene, &context, &ray);
                    hits[kind] += ray.tfar == -std::numeric_limits<float>::infinity();
                } else {
                    RTCRayHit hit;
                    hit.ray = prepared(from);
                    hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
                    hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
                    rtcIntersect1(scene, &context, &hit);
                    hits[kind] += hit.hit.geomID != RTC_INVALID_GEOMETRY_ID;
                }
            }
            speed[kind] = rays[kind].size() / 1e6 / (thread_seconds() - begin);
        }
        std::printf("{\"program\": \"embree\", \"triangles\": %u, \"build_s\": %.3f, \"build_robust_s\": %.3f, \"primary\": %.3f, "
                    "\"bounce\": %.3f, \"shadow\": %.3f, \"hits\": [%zu, %zu, %zu]}\n",
                    n[0], build[0], build[1], speed[0], speed[1], speed[2], hits[0], hits[1], hits[2]);
    }
}
